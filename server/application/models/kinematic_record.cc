#include "server/application/models/kinematic_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "server/application/models/fit_options.h"
#include "server/calibration/design/predict.h"
#include "server/calibration/linear/tail.h"
#include "server/calibration/report/residual_statistics.h"
#include "server/core/data/row_marks.h"
#include "server/core/reasons.h"
#include "server/core/text/quantity_text.h"
#include "server/core/try.h"
#include "server/core/unit_conversion.h"
#include "server/diagnosis/report/sentence.h"
#include "server/diagnosis/robot/robot_diagnosis.h"
#include "server/effects/term_order.h"
#include "server/formats/cell_file/kinematics_section.h"
#include "server/formats/formula/formula.h"
#include "server/formats/model/model_json.h"
#include "server/identification/accuracy.h"
#include "server/identification/pose_influences.h"
#include "server/identification/pose_rows.h"
#include "server/kinematics/angles.h"
#include "server/kinematics/drawing.h"
#include "server/kinematics/mechanism.h"

namespace driftwise::application {
namespace {

using Eigen::Index;
using kinematics::Mechanism;

// Largest difference of a robot's numbers from its drawing: a length, and a share of the drawing's
// longest length. A robot of the same make differs by a few millimetres at most, one of
// another size by centimetres.
constexpr double kMostDeviation_mm = 20, kMostDeviation = 0.05;

tl::unexpected<Error> other_robot(const std::string& what) {
  return fail(ErrorCode::failed_precondition, reasons::kOtherRobot,
              fmt::format("the robot file is of another robot than this cell's: {}", what));
}

std::string names_of(const std::vector<Channel>& channels) {
  std::string text;
  for (const auto& channel : channels) text += (text.empty() ? "" : ", ") + channel.name();
  return text;
}

std::vector<Channel> motors_of(const Mechanism& robot) {
  if (!robot.predicts_pose()) return robot.outputs();
  return {robot.inputs().begin(),
          robot.inputs().begin() + static_cast<std::ptrdiff_t>(robot.description().links.size())};
}

double longest_mm(const kinematics::Parameters& parameters) {
  double longest = 0;
  for (const auto& one : parameters)
    if (one.name.ends_with("_mm") && !one.name.starts_with("frame"))
      longest = std::max(longest, std::abs(one.nominal));
  return longest;
}

// A parameter of the robot itself: its place, its tool and its zeros do not tell robots apart.
bool says_which_robot(const kinematics::Parameter& parameter) {
  return !parameter.placement && !parameter.name.starts_with("frame.") &&
         !parameter.name.starts_with("tool.") && !parameter.name.ends_with(".theta_deg");
}

Result<void> check_same_robot(const CellDescription& cell, const Mechanism& robot) {
  DRIFTWISE_TRY(const auto drawing, kinematics::make_mechanism(*cell.kinematics));
  if (drawing->description().kind != robot.description().kind)
    return other_robot(fmt::format("found a {}, expected a {} as in [kinematics] of the cell file",
                                   robot.description().kind, drawing->description().kind));
  const auto motors = motors_of(robot), expected = motors_of(*drawing);
  if (motors != expected)
    return other_robot(
        fmt::format("found the motors {}, expected {}", names_of(motors), names_of(expected)));
  const auto axes = cell.motor_channels();
  for (const auto& motor : motors)
    if (motor.unit == "mm" && !axes.empty() && std::ranges::find(axes, motor) == axes.end())
      return other_robot(
          fmt::format("the cell has no axis {}, only {}", motor.name(), names_of(axes)));
  const auto &given = robot.parameters(), &drawn = drawing->parameters();
  const double allowed =  // of natural units: kNaturalLength_mm, or the angle that moves as much
      std::min(kMostDeviation_mm, kMostDeviation * longest_mm(drawn)) /
      kinematics::kNaturalLength_mm;
  for (const auto& one : given) {
    const auto same = std::ranges::find(drawn, one.name, &kinematics::Parameter::name);
    if (!says_which_robot(one)) continue;
    if (same == drawn.end())
      return other_robot(fmt::format("the cell's drawing has no {}", one.name));
    if (allowed > 0 && std::abs(one.nominal - same->nominal) > allowed * same->natural)
      return other_robot(fmt::format(
          "{} is {}, in the cell's drawing {}: more apart than a robot is from its drawing",
          one.name, digits_text(one.nominal, 7), digits_text(same->nominal, 7)));
  }
  return {};
}

calibration::Accuracy accuracy_of(const identification::OutputFigures& figures, double rss,
                                  int dof) {
  calibration::Accuracy accuracy;
  accuracy.rmse = std::sqrt(rss / std::max(1, dof));
  accuracy.u90_calibration = figures.u90_calibration;
  accuracy.mean_calibration = figures.mean_calibration;
  accuracy.a90_calibration = figures.a90_calibration;
  accuracy.u90_validation = figures.u90_validation;
  accuracy.mean_validation = figures.mean_validation;
  accuracy.a90_validation = figures.a90_validation;
  accuracy.pure_error = figures.pure_error;
  if (const auto& blocks = figures.blocks) {
    accuracy.u90_blocks = blocks->figures.u90;
    accuracy.u90_blocks_low = blocks->u90_low;
    accuracy.u90_blocks_high = blocks->u90_high;
    accuracy.mean_blocks = blocks->figures.mean;
    accuracy.a90_blocks = blocks->figures.a90;
    accuracy.a90_blocks_low = blocks->low;
    accuracy.a90_blocks_high = blocks->high;
    accuracy.block_count = blocks->folds;
  }
  return accuracy;
}

calibration::OutputModel output_of(const identification::Judgement& judged, std::size_t index) {
  const auto& found = *judged.fitted.kinematics;
  const auto at = static_cast<Index>(index);
  calibration::OutputModel output;
  output.channel = judged.fitted.outputs[index];
  output.dof = static_cast<int>(found.rows) - judged.fitted.parameters(index);
  output.accuracy = accuracy_of(judged.outputs[index], found.rss[at], output.dof);
  output.accuracy.condition_index = found.condition;
  output.terms = found.terms;
  output.coefficients.resize(static_cast<Index>(found.terms.size()));
  for (std::size_t k = 0; k < found.terms.size(); ++k) {
    const auto term = static_cast<Index>(k);
    calibration::TermReport report;
    report.term = found.terms[k];
    report.in = true;
    output.coefficients[term] = report.coefficient = found.coefficients(term, at);
    report.standard_error = found.standard_errors(term, at);
    report.t = report.standard_error > 0 ? report.coefficient / report.standard_error : 0;
    report.p = report.standard_error > 0 ? calibration::t_two_sided_p(report.t, output.dof) : 1;
    output.report.push_back(std::move(report));
  }
  output.covariance = found.terms.empty() ? Eigen::MatrixXd(0, 0) : found.term_covariances[index];
  return output;
}

// Autocorrelation of the residuals, and what each term moves, over the calibration rows.
Result<void> add_row_figures(const Dataset& data, const identification::Identification& found,
                             calibration::Model& model) {
  DRIFTWISE_TRY(const auto read, identification::mechanism_data(data, *found.mechanism));
  DRIFTWISE_TRY(const auto predicted, identification::predict(data, found));
  DRIFTWISE_TRY(const auto columns, calibration::raw_columns(data, found.terms));
  auto rows = identification::complete_rows(data, PointSet::calibration,
                                            {&predicted, &read.outputs, &columns});
  // The first ones, where so many were asked for.
  rows.resize(std::min(rows.size(), static_cast<std::size_t>(found.rows)));
  if (rows.empty()) return {};
  const std::vector<Index> at(rows.begin(), rows.end());
  for (std::size_t o = 0; o < model.outputs.size(); ++o) {
    auto& output = model.outputs[o];
    const auto column = static_cast<Index>(o);
    const Eigen::VectorXd residuals = (read.outputs - predicted)(at, column);
    auto& accuracy = output.accuracy;
    accuracy.lag1_autocorrelation = calibration::lag1_autocorrelation(residuals);
    accuracy.effective_rows =
        calibration::effective_rows(residuals.size(), accuracy.lag1_autocorrelation);
    for (std::size_t k = 0; k < output.report.size(); ++k) {
      auto& report = output.report[k];
      if (report.term.is_constant()) continue;
      Eigen::VectorXd moved = report.coefficient * columns(at, static_cast<Index>(k));
      moved.array() -= moved.mean();
      report.contribution_rms = std::sqrt(moved.squaredNorm() / static_cast<double>(moved.size()));
      report.contribution_max = moved.cwiseAbs().maxCoeff();
    }
  }
  return {};
}

// Over the calibration rows, in the unit of the channel.
void add_range(const Dataset& data, const Channel& channel, calibration::Model& model) {
  const auto* column = data.find(channel.symbol);
  if (column == nullptr) return;
  const auto conversion = unit_conversion(column->channel.unit, channel.unit);
  if (!conversion) return;
  calibration::ChannelRange range{channel, INFINITY, -INFINITY};
  for (std::size_t row = 0; row < data.rows; ++row) {
    if (data.set_of(row) != PointSet::calibration || data.is_excluded(row) ||
        !std::isfinite(column->values[row]))
      continue;
    const double value = (*conversion)(column->values[row]);
    range.min = std::min(range.min, value);
    range.max = std::max(range.max, value);
  }
  if (range.min <= range.max) model.domain.push_back(range);
}

void add_domain(const Dataset& data, const Mechanism& robot, calibration::Model& model) {
  std::set<std::string> known;
  const auto add = [&](const Channel& channel) {
    if (known.insert(channel.symbol).second) add_range(data, channel, model);
  };
  if (robot.predicts_pose())
    for (const auto& channel : robot.outputs()) add(channel);
  for (const auto& channel : robot.inputs()) add(channel);
  for (const auto& output : model.outputs)
    for (const auto& term : output.terms)
      for (const auto& symbol : effects::symbols_of(term))
        if (const auto* column = data.find(symbol)) add(column->channel);
}

// Numbers that no robot file may state are no robot's: signs, order or units of the rows are wrong.
// They are held against the ranges of the file, which is how a model keeps its robot.
Result<void> check_plausible(const KinematicsDescription& robot, std::int64_t rows) {
  const auto read = formats::parse_robot_file(formats::write_robot_file(robot), "identified robot");
  if (read) return {};
  return fail(ErrorCode::failed_precondition, reasons::kBadKinematics,
              fmt::format("identified on {} rows, this is no robot that a robot file can describe, "
                          "so nothing is stored: {}; compare with the drawing the signs of the "
                          "measured lengths and of the motors, the order of the motors, and the "
                          "units of the rows",
                          rows, read.error().message));
}

Result<calibration::Model> model_of(const Dataset& data, const identification::Judgement& judged,
                                    const KinematicRequest& request, calibration::Lineage lineage) {
  const auto& found = *judged.fitted.kinematics;
  calibration::Model model;
  model.formula = found.mechanism->description().kind + ", identified";
  if (!request.fit.formula.empty()) model.formula += ", beside it " + request.fit.formula;
  model.select = "all";
  model.lineage = std::move(lineage);
  model.lineage.rows_calibration = judged.rows_calibration;
  model.lineage.rows_validation = judged.rows_validation;
  model.lineage.rows_dropped =
      static_cast<std::int64_t>(data.rows) - judged.rows_calibration - judged.rows_validation;
  for (std::size_t row = 0; row < data.rows; ++row)
    if (data.is_excluded(row)) {
      if (!is_passage(data, row)) ++model.lineage.rows_excluded;
      --model.lineage.rows_dropped;
    }
  model.warnings = judged.warnings;
  model.fit_us = judged.fitted.fit_us;
  for (std::size_t o = 0; o < judged.outputs.size(); ++o)
    model.outputs.push_back(output_of(judged, o));
  DRIFTWISE_RETURN_IF_ERROR(add_row_figures(data, found, model));
  add_domain(data, *found.mechanism, model);
  calibration::Geometry geometry{
      kinematics::with_values(*found.mechanism, found.values()), {}, found.covariance};
  for (const auto& [parameter, value, standard_error, free, note] : found.parameters)
    geometry.parameters.push_back({parameter.name, value, standard_error, free, note});
  DRIFTWISE_RETURN_IF_ERROR(check_plausible(geometry.robot, judged.rows_calibration));
  model.geometry = std::move(geometry);
  DRIFTWISE_RETURN_IF_ERROR(identification::add_pose_influences(data, found, model));
  return model;
}

// Record of a model that reads back: one that does not would be in the database for good.
Result<ModelRecord> record_of(const calibration::Model& model, const KinematicRequest& request) {
  ModelRecord record;
  record.name = request.fit.name.empty() ? model.formula : request.fit.name;
  record.note = request.fit.note;
  record.json = formats::write_model_json(model);
  record.hash = formats::model_hash(model);
  if (const auto back = formats::read_model_json(record.json); !back)
    return fail(ErrorCode::failed_precondition, reasons::kBadKinematics,
                fmt::format("the model made does not read back, so nothing is stored: {}; compare "
                            "the numbers of the robot file and the units of the rows",
                            back.error().message));
  return record;
}

calibration::Model imported_model(const Mechanism& robot) {
  calibration::Model model;
  model.formula = robot.description().kind + ", as in the robot file";
  model.select = "all";
  model.lineage.source = "robot file";
  model.warnings.push_back(
      "imported: no data judged it, so neither its domain nor its uncertainty is known");
  model.geometry = calibration::Geometry{robot.description(), {}, {}};
  return model;
}

Result<identification::MethodOptions> method_options(const Dataset& data,
                                                     const KinematicRequest& request) {
  identification::MethodOptions options;
  DRIFTWISE_TRY(auto fit, fit_options_from(request.fit, data, source_of(request.fit)));
  options.fit = std::move(fit);
  if (request.fit.formula.empty()) return options;
  DRIFTWISE_TRY(const auto formula, formats::Formula::parse(request.fit.formula));
  DRIFTWISE_TRY(auto candidates, formula.expand(data));
  options.fit.candidates = std::move(candidates);
  return options;
}

}  // namespace

Result<KinematicFit> kinematic_record(const std::optional<Dataset>& data,
                                      const KinematicRequest& request,
                                      const CellDescription& cell) {
  if (!cell.kinematics)
    return fail(ErrorCode::failed_precondition, reasons::kNoKinematics,
                "the cell file has no [kinematics]: nothing says which robot this is; add the "
                "section (docs/kinematics.md)");
  auto geometry = *cell.kinematics;
  if (!request.robot.empty()) {
    DRIFTWISE_TRY(auto given, formats::parse_robot_file(request.robot, "robot file"));
    geometry = std::move(given);
  }
  DRIFTWISE_TRY(auto mechanism, kinematics::make_mechanism(geometry));
  DRIFTWISE_RETURN_IF_ERROR(check_same_robot(cell, *mechanism));
  if (request.joint_errors && (!data || !mechanism->predicts_pose()))
    return fail(ErrorCode::invalid_argument, reasons::kBadOptions,
                std::string("joint errors are found on data of a serial-arm, found ") +
                    (data ? "a " + geometry.kind : "no data"));
  if (!data) {
    DRIFTWISE_TRY(auto record, record_of(imported_model(*mechanism), request));
    return KinematicFit{std::move(record), {}};
  }

  DRIFTWISE_TRY(auto options, method_options(*data, request));
  KinematicFit made;
  std::vector<std::string> hold = geometry.hold;
  if (request.joint_errors) {
    diagnosis::DiagnoseOptions diagnose;
    diagnose.baseline = options.fit.candidates;
    diagnose.executor = options.fit.executor;
    DRIFTWISE_TRY(const auto found, diagnosis::diagnose_robot(*data, mechanism, diagnose));
    for (const auto& finding : found.diagnosis.findings)
      made.findings.push_back(diagnosis::sentence(finding));
    // From the numbers as drawn: which of them these rows hide is asked of the drawing.
    for (std::size_t k = 0; k < geometry.links.size(); ++k)
      geometry.links[k].errors = found.robot.links[k].errors;
    hold = found.robot.hold;
    DRIFTWISE_TRY(mechanism, kinematics::make_mechanism(geometry));
  }
  options.mechanism = mechanism;
  identification::JudgeOptions judge;
  judge.blocks = request.fit.blocks;
  const auto lineage = options.fit.lineage;
  DRIFTWISE_TRY(const auto judged, identification::judge_method(
                                       *data, identification::Method::kinematic, options, judge));
  DRIFTWISE_TRY(auto model, model_of(*data, judged, request, lineage));
  model.geometry->robot.hold = hold;
  DRIFTWISE_TRY(made.model, record_of(model, request));
  return made;
}

}  // namespace driftwise::application
