#include "server/diagnosis/robot/robot_diagnosis.h"

#include <algorithm>

#include "server/core/data/unusable_values.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/diagnosis/answer/cancelled.h"
#include "server/diagnosis/answer/u90.h"
#include "server/diagnosis/diagnose.h"
#include "server/diagnosis/report/sentence.h"
#include "server/diagnosis/robot/arm_diagnosis.h"
#include "server/diagnosis/robot/geometry.h"
#include "server/identification/identifiability.h"
#include "server/identification/pose_rows.h"
#include "server/kinematics/drawing.h"

namespace driftwise::diagnosis {
namespace {

using Eigen::Index;

constexpr double kArmDone = 0.1, kGeometryDone = 0.2;  // of the way

std::vector<std::string> symbols_of(const std::vector<Channel>& channels) {
  std::vector<std::string> symbols;
  for (const auto& channel : channels) symbols.push_back(channel.symbol);
  return symbols;
}

Result<calibration::Candidates> checked_baseline(const calibration::Candidates& baseline,
                                                 const kinematics::Mechanism& mechanism) {
  calibration::Candidates result = baseline;
  result.outputs = symbols_of(mechanism.outputs());
  if (result.formula.empty()) {
    for (const auto& output : result.outputs)
      result.formula += (result.formula.empty() ? "" : ", ") + output;
    result.formula += " ~ kinematics";
  }
  auto asked = baseline.outputs, predicted = result.outputs;
  std::ranges::sort(asked);
  std::ranges::sort(predicted);
  if (asked.empty() || asked == predicted) return result;
  std::string left, right, written;
  for (const auto& one : asked) left += (left.empty() ? "" : ", ") + one;
  for (const auto& one : result.outputs) right += (right.empty() ? "" : ", ") + one;
  for (const auto& one : result.outputs) written += (written.empty() ? "" : " + ") + one;
  return fail(ErrorCode::invalid_argument, reasons::kOtherOutputs,
              "the baseline's left side has " + left + ", but this robot's kinematics predicts " +
                  right + ": write \"" + written + " ~ ...\"");
}

// The figures "before" are the drawing's: what was found of it is part of the gain.
void begin_at_drawing(const Problem& problem, const Dataset& data, const Eigen::MatrixXd& nominal,
                      Diagnosis& diagnosis) {
  for (std::size_t o = 0; o < problem.outputs.size(); ++o) {
    const auto& output = problem.outputs[o];
    auto& summary = diagnosis.outputs[o];
    const Eigen::VectorXd left =
        output.measured - output.factor * nominal.col(static_cast<Index>(o));
    summary.before.assign(left.data(), left.data() + left.size());
    const ErrorFigures learned = figures_of(rows_of(left, problem.learn));
    summary.u90 = summary.u90_calibration_before = learned.u90;
    summary.mean = summary.mean_calibration_before = learned.mean;
    summary.a90 = summary.a90_calibration_before = learned.a90;
    if (summary.u90_validation_before) {
      const ErrorFigures judged = figures_of(rows_of(left, problem.judge));
      summary.u90_validation_before = judged.u90;
      summary.mean_validation_before = judged.mean;
      summary.a90_validation_before = judged.a90;
    }
    for (auto& share : summary.explained_by)
      share.share = share.variable == "time"
                        ? marginal_share(data.time_s, summary.before)
                        : marginal_share(data.find(share.variable)->values, summary.before);
    std::ranges::stable_sort(summary.explained_by, std::ranges::greater{}, &Share::share);
  }
}

// The robot as it is given, only placed by a fit.
Result<identification::Identification> as_drawn(
    const Dataset& data, const Problem& problem,
    const std::shared_ptr<const kinematics::Mechanism>& mechanism,
    const std::vector<effects::Term>& terms) {
  identification::IdentifyOptions options;
  options.mechanism = mechanism;
  options.terms = terms;
  options.placement_only = true;
  return identification::identify(marked_rows(data, problem), options);
}

// data: rows in which the mechanism's inputs have values.
Result<RobotDiagnosis> diagnose_rows(const Dataset& data,
                                     const std::shared_ptr<const kinematics::Mechanism>& mechanism,
                                     const DiagnoseOptions& options) {
  DiagnoseOptions further = options;
  DRIFTWISE_TRY(auto baseline, checked_baseline(options.baseline, *mechanism));
  further.baseline = std::move(baseline);
  DRIFTWISE_TRY(const auto problem, lay_out(data, further.baseline,
                                            std::max<std::size_t>(1, data.rows), Judging::apart));
  // What an arm's kinematics predicts cannot be what a cause reads: its simulation starts from the
  // joints.
  if (mechanism->predicts_pose())
    further.exclude_symbols.insert(further.exclude_symbols.end(), further.baseline.outputs.begin(),
                                   further.baseline.outputs.end());
  const auto tell = [&](double fraction, const std::string& step) {
    return !options.progress || options.progress(fraction, step);
  };
  if (!tell(0, "identifying the robot")) return cancelled();
  DRIFTWISE_TRY(const auto placed, as_drawn(data, problem, mechanism, further.baseline.terms));
  const auto nominal = identification::predict(data, placed);
  // The joints' errors beyond every number of the drawing, then its numbers with those errors in.
  ArmDiagnosis arm{.robot = mechanism->description()};
  auto with_errors = mechanism;
  if (mechanism->predicts_pose()) {
    DRIFTWISE_TRY(auto found,
                  diagnose_arm(data, problem, mechanism, further.baseline.terms, options.alpha,
                               [&] { return tell(kArmDone / 2, "comparing the joints"); }));
    arm = std::move(found);
    DRIFTWISE_TRY(auto made, kinematics::make_mechanism(arm.robot));
    with_errors = std::move(made);
  }
  const Dataset& moved = arm.behind_plays ? *arm.behind_plays : data;
  DRIFTWISE_TRY(
      auto geometry,
      diagnose_geometry(moved, problem, with_errors, further.baseline.terms, options.alpha, [&] {
        return tell((kArmDone + kGeometryDone) / 2, "comparing the numbers of the drawing");
      }));
  auto extended = identification::predict(moved, geometry.extended);
  DRIFTWISE_RETURN_IF_ERROR(nominal);
  DRIFTWISE_RETURN_IF_ERROR(extended);
  further.simulated = std::move(*extended);
  further.progress = [&](double fraction, const std::string& step) {
    return tell(kGeometryDone + (1 - kGeometryDone) * fraction, step);
  };
  DRIFTWISE_TRY(auto found, diagnose(data, further));
  begin_at_drawing(problem, data, *nominal, found);
  found.findings.insert(found.findings.begin(), std::make_move_iterator(geometry.findings.begin()),
                        std::make_move_iterator(geometry.findings.end()));
  found.findings.insert(found.findings.begin(), std::make_move_iterator(arm.findings.begin()),
                        std::make_move_iterator(arm.findings.end()));
  found.warnings.insert(found.warnings.end(), arm.warnings.begin(), arm.warnings.end());
  found.not_testable.insert(found.not_testable.begin(),
                            std::make_move_iterator(arm.not_testable.begin()),
                            std::make_move_iterator(arm.not_testable.end()));
  // Once the drawing has crooked numbers, data could tell these apart, but so faintly that the next
  // identification would move them by decimetres for nothing. What only these rows hide is a note:
  // the next rows may show it.
  DRIFTWISE_TRY(const auto rows, identification::mechanism_data(data, *with_errors));
  const auto held =
      identification::hidden_in_every_posture(*with_errors, geometry.nominal.values(), rows.inputs);
  std::erase_if(found.not_testable,  // it was asked here
                [](const NotTestable& one) { return one.cause == "geometry_parameter"; });
  found.not_testable.insert(found.not_testable.begin(),
                            std::make_move_iterator(geometry.held.begin()),
                            std::make_move_iterator(geometry.held.end()));
  if (found.verdict == Verdict::adequate && !found.findings.empty())
    found.verdict = Verdict::extended;
  KinematicsDescription robot = kinematics::with_values(*with_errors, geometry.extended.values());
  robot.hold.insert(robot.hold.end(), held.begin(), held.end());
  return RobotDiagnosis{std::move(found), std::move(robot)};
}

auto outliers_in(std::vector<Finding>& findings) {
  return std::ranges::find(findings, "outliers", &Finding::cause);
}

}  // namespace

Result<RobotDiagnosis> diagnose_robot(const Dataset& dataset,
                                      const std::shared_ptr<const kinematics::Mechanism>& mechanism,
                                      const DiagnoseOptions& options) {
  if (const auto usable = without_unusable(dataset))
    return diagnose_robot(usable->data, mechanism, options);
  Dataset data = identification::without_incomplete_rows(dataset, symbols_of(mechanism->inputs()));
  DRIFTWISE_TRY(auto found, diagnose_rows(data, mechanism, options));
  const auto wrong = outliers_in(found.diagnosis.findings);
  if (wrong == found.diagnosis.findings.end()) return found;
  // The robot was identified with the wrong rows in: once more without them.
  Finding outliers = std::move(*wrong);
  data.excluded.resize(data.rows);
  for (const std::size_t row : outliers.rows) data.excluded[row] = 1;
  DiagnoseOptions again = options;
  if (options.progress)
    again.progress = [&](double, const std::string& step) {
      return options.progress(1, "without the wrong rows: " + step);
    };
  DRIFTWISE_TRY(auto rest, diagnose_rows(data, mechanism, again));
  auto& findings = rest.diagnosis.findings;
  if (const auto more = outliers_in(findings); more != findings.end()) {
    outliers.rows.insert(outliers.rows.end(), more->rows.begin(), more->rows.end());
    std::ranges::sort(outliers.rows);
    outliers.parameters = {{"count", static_cast<double>(outliers.rows.size()), {}, {}}};
    outliers.sentence = sentence(outliers);
    findings.erase(more);
  }
  findings.push_back(std::move(outliers));
  if (rest.diagnosis.verdict == Verdict::adequate) rest.diagnosis.verdict = Verdict::extended;
  return rest;
}

}  // namespace driftwise::diagnosis
