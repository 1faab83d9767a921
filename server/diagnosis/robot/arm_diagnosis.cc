#include "server/diagnosis/robot/arm_diagnosis.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "server/core/try.h"
#include "server/core/units.h"
#include "server/diagnosis/answer/cancelled.h"
#include "server/diagnosis/answer/u90.h"
#include "server/diagnosis/report/sentence.h"
#include "server/diagnosis/robot/geometry.h"
#include "server/diagnosis/robot/left_out.h"
#include "server/identification/identify.h"
#include "server/identification/pose_rows.h"
#include "server/kinematics/joint_errors.h"

namespace driftwise::diagnosis {
namespace {

using Eigen::Index;

JointTurns turns_of(const std::vector<ArmCause>& causes, std::size_t rows) {
  Index shapes = 0;
  for (const auto& cause : causes) shapes += cause.turns_rad.cols();
  JointTurns turns{Eigen::MatrixXd(static_cast<Index>(rows), shapes), {}};
  for (const auto& cause : causes) {
    const auto at = static_cast<Index>(turns.joint.size());
    turns.rad.middleCols(at, cause.turns_rad.cols()) = cause.turns_rad;
    turns.joint.insert(turns.joint.end(), static_cast<std::size_t>(cause.turns_rad.cols()),
                       cause.joint);
  }
  return turns;
}

// Columns of what is in without a prior: the numbers that such data determine, and linear terms.
std::vector<Index> geometry_columns(const identification::Identification& identified,
                                    Index before_turns) {
  std::vector<Index> columns;
  const auto parameters = static_cast<Index>(identified.parameters.size());
  for (Index k = 0; k < before_turns; ++k)
    if (k >= parameters || identified.parameters[static_cast<std::size_t>(k)].free)
      columns.push_back(k);
  return columns;
}

std::string name_of_cause(const ArmCause& cause) {
  return cause.id + " " + cause.subject + (cause.by_motion ? " by motion" : "") +
         (cause.harmonic > 0 ? " harmonic " + std::to_string(cause.harmonic) : "");
}

void add_parameters(const ArmCause& cause, const NamedArmCause& named, bool masses,
                    Finding& found) {
  const auto linear = [&](const char* name) {
    const double value = named.amplitude[0], reach = kSigmaToU90 * named.error[0];
    found.parameters.push_back({name, value, Interval{value - reach, value + reach}, {}});
  };
  if (cause.id == "joint_compliance") {
    linear(masses ? "sag_urad_per_newton_m" : "sag_urad_per_m");
  } else if (cause.id == "backlash") {
    linear(cause.by_motion ? "width_by_motion_arcsec" : "width_arcsec");
  } else if (cause.id == "joint_offset_drift") {
    linear("drift_arcsec_per_k");
  } else {
    const double size = named.amplitude.norm();
    const double error = std::sqrt(named.amplitude.cwiseProduct(named.error).squaredNorm()) / size;
    const double reach = kSigmaToU90 * error;
    found.parameters.push_back({"harmonic", static_cast<double>(cause.harmonic), {}, {}});
    found.parameters.push_back(
        {"amplitude_arcsec", size, Interval{std::max(0.0, size - reach), size + reach}, {}});
  }
}

const char* unit_of(const ArmCause& cause, bool masses) {
  if (cause.id == "joint_compliance") return masses ? "urad/(N m)" : "urad/m";
  return cause.id == "joint_offset_drift" ? "arcsec/K" : "arcsec";
}

// Causes whose typical size such rows hide: what is left of it beside the numbers of the drawing is
// less than the noise. A larger one may still be named.
void add_hidden(const ArmSearch& search, const std::vector<ArmCause>& causes, bool masses,
                std::vector<NotTestable>& result) {
  for (std::size_t c = 0; c < causes.size(); ++c) {
    const double least = search.least_shown(c), typical = causes[c].typical;
    if (least <= typical) continue;
    char text[200];
    const char* unit = unit_of(causes[c], masses);
    if (least > causes[c].range * typical)
      std::snprintf(text, sizeof text,
                    "beside the numbers of the drawing these rows hide it at any size that it may "
                    "have; %.2g %s is typical",
                    typical, unit);
    else
      std::snprintf(text, sizeof text,
                    "beside the numbers of the drawing these rows show it from %.2g %s on; %.2g is "
                    "typical",
                    least, unit, typical);
    result.push_back({name_of_cause(causes[c]), text});
  }
}

class Reporter {
 public:
  Reporter(const Problem& problem, const WhitenedGeometry& whole, const ArmSearch& search,
           const std::vector<ArmCause>& causes, const std::vector<Index>& geometry)
      : problem_(problem),
        whole_(whole),
        search_(search),
        causes_(causes),
        coefficients_(search.coefficients()),
        raw_base_(whole.raw(Eigen::all, geometry)) {
    const Eigen::RowVectorXd lengths = raw_base_.colwise().norm().cwiseMax(1e-300);
    raw_base_ = raw_base_ * lengths.cwiseInverse().asDiagonal();
    for (const auto& cause : causes) {
      first_.push_back(turns_);
      turns_ += cause.turns_rad.cols();
    }
  }

  Finding finding(const NamedArmCause& named, bool masses) const {
    const ArmCause& cause = causes_[named.cause];
    Finding found{.cause = cause.id, .subject = cause.subject, .where = "robot"};
    add_parameters(cause, named, masses, found);
    found.p_adjusted = named.p_adjusted;
    found.log_likelihood_ratio = named.two_ln_bf / 2;
    for (const std::size_t rival : named.rivals)
      found.indistinguishable_from.push_back(name_of_cause(causes_[rival]));
    add_outputs(named, found);
    found.sentence = sentence(found);
    return found;
  }

 private:
  // What it adds to the identified drawing and to the other causes.
  void add_outputs(const NamedArmCause& named, Finding& found) const {
    const Index at = whole_.raw.cols() - turns_ + first_[named.cause],
                k = causes_[named.cause].turns_rad.cols();
    const Eigen::VectorXd effect = whole_.raw.middleCols(at, k) * coefficients_.segment(at, k);
    const Eigen::VectorXd beyond = effect - raw_base_ * raw_base_.householderQr().solve(effect);
    const Eigen::VectorXd before =
        whole_.y_raw_judge - whole_.raw_judge * search_.coefficients(named.cause);
    const Eigen::VectorXd after = whole_.y_raw_judge - whole_.raw_judge * coefficients_;
    found.outputs = outputs_moved(problem_, beyond, before, after);
  }

  const Problem& problem_;
  const WhitenedGeometry& whole_;
  const ArmSearch& search_;
  const std::vector<ArmCause>& causes_;
  Eigen::VectorXd coefficients_;
  Eigen::MatrixXd raw_base_;
  std::vector<Index> first_;
  Index turns_ = 0;
};

// Angles of the cause's joint with its turns in.
void turn_joint(const ArmCause& cause, const Eigen::VectorXd& amplitude,
                const KinematicsDescription& arm, Dataset& data) {
  const Channel& motor = arm.links[cause.joint].motor;
  const double per_rad = motor.unit == "deg" ? 1 / kRadPerDeg : 1;
  const Eigen::VectorXd turns = per_rad * (cause.turns_rad * amplitude);
  for (auto& column : data.columns)
    if (column.channel.symbol == motor.symbol)
      for (std::size_t row = 0; row < data.rows; ++row)
        column.values[row] += turns[static_cast<Index>(row)];
}

std::string refusal(const RefusedArmCause& refused, const ArmCause& cause) {
  const auto& gate = refused.gate;
  const bool predicts = gate.by_time > 0 && gate.by_places > 0 && gate.by_driver > 0;
  char text[400];
  std::snprintf(text, sizeof text,
                "%s is refused (evidence %.0f): %s. 2 ln of the density of rows left out grows by "
                "%.0f over blocks of time, %.0f over groups of poses, %.0f over six parts of what "
                "it goes with; left out one by one, they let its size vary by %.0f %%",
                name_of_cause(cause).c_str(), refused.two_ln_bf,
                predicts ? "its size rests on some of these rows"
                         : "rows left out are not predicted better by it",
                gate.by_time, gate.by_places, gate.by_driver,
                100 / std::max(gate.t_by_driver, 0.01));
  return text;
}

}  // namespace

Result<ArmDiagnosis> diagnose_arm(const Dataset& dataset, const Problem& problem,
                                  const std::shared_ptr<const kinematics::Mechanism>& mechanism,
                                  const std::vector<effects::Term>& terms, double alpha,
                                  const std::function<bool()>& tick) {
  ArmDiagnosis result{.robot = mechanism->description()};
  const Dataset data = marked_rows(dataset, problem);
  auto catalogue = arm_causes(data, problem.learn, result.robot);
  result.not_testable = std::move(catalogue.not_testable);
  const auto& causes = catalogue.causes;
  if (causes.empty()) return result;
  identification::IdentifyOptions options;
  options.mechanism = mechanism;
  options.terms = terms;
  // A shift of the whole arm with a temperature is thermal_offset's: a joint's drift is what turns.
  for (const auto& cause : causes)
    if (!cause.channel.symbol.empty()) {
      const effects::Term offset{{effects::Power{cause.channel.symbol, 1}}};
      if (std::ranges::find(options.terms, offset) == options.terms.end())
        options.terms.push_back(offset);
    }
  DRIFTWISE_TRY(const auto identified, identification::identify(data, options));
  if (tick && !tick()) return cancelled();
  const JointTurns turns = turns_of(causes, data.rows);
  const auto whole = plain_geometry(data, problem, identified, turns);
  const auto geometry =
      geometry_columns(identified, whole.columns.cols() - static_cast<Index>(turns.joint.size()));
  DRIFTWISE_TRY(const auto rows, identification::mechanism_data(data, *mechanism));
  ArmSearch search(whole, geometry, causes,
                   scaled_rows(rows.inputs.topRows(std::ssize(result.robot.links)), problem.learn),
                   problem.learn);
  search.search(alpha);
  const Reporter reporter(problem, whole, search, causes, geometry);
  const bool masses = kinematics::has_masses(result.robot);
  for (const auto& one : search.named()) {
    result.findings.push_back(reporter.finding(one, masses));
    add_to(result.robot, causes[one.cause], one.amplitude);
    if (!causes[one.cause].by_motion) continue;
    if (!result.behind_plays) result.behind_plays = dataset;
    turn_joint(causes[one.cause], one.amplitude, result.robot, *result.behind_plays);
  }
  add_hidden(search, causes, masses, result.not_testable);
  for (const auto& one : search.refused())
    result.warnings.push_back(refusal(one, causes[one.cause]));
  for (const std::size_t one : search.withdrawn())
    result.warnings.push_back(name_of_cause(causes[one]) +
                              ": with it the rows that took no part in finding it are described "
                              "worse, and it was withdrawn");
  return result;
}

}  // namespace driftwise::diagnosis
