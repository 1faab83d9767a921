#include "server/rpc/model/convert_study.h"

#include <chrono>
#include <nlohmann/json.hpp>

#include "server/core/channel.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/model/method_json.h"
#include "server/formats/text/text.h"
#include "server/rpc/model/fit_request.h"
#include "server/rpc/shared/convert_values.h"
#include "server/rpc/shared/request_checks.h"

namespace driftwise::rpc {
namespace {

v1::MethodOutcome outcome_from(const identification::Judgement& judgement) {
  v1::MethodOutcome out;
  out.set_method(identification::name_of(judgement.fitted.method));
  out.set_parameter_count(judgement.fitted.parameters());
  for (const auto& figures : judgement.outputs) {
    const auto summary = summary_unit(figures.channel.unit);
    auto& output = *out.add_outputs();
    output.set_channel(figures.channel.name());
    output.set_unit(summary.unit);
    output.set_parameter_count(figures.parameters);
    output.set_rms(figures.rms * summary.factor);
    output.set_u90_calibration(figures.u90_calibration * summary.factor);
    if (figures.u90_validation) output.set_u90_validation(*figures.u90_validation * summary.factor);
    output.set_mean_calibration(figures.mean_calibration * summary.factor);
    output.set_a90_calibration(figures.a90_calibration * summary.factor);
    if (figures.mean_validation)
      output.set_mean_validation(*figures.mean_validation * summary.factor);
    if (figures.a90_validation) output.set_a90_validation(*figures.a90_validation * summary.factor);
    if (figures.blocks) {
      output.set_u90_blocks(figures.blocks->figures.u90 * summary.factor);
      output.set_mean_blocks(figures.blocks->figures.mean * summary.factor);
      output.set_a90_blocks(figures.blocks->figures.a90 * summary.factor);
    }
    if (figures.groups) {
      output.set_u90_groups(figures.groups->figures.u90 * summary.factor);
      output.set_mean_groups(figures.groups->figures.mean * summary.factor);
      output.set_a90_groups(figures.groups->figures.a90 * summary.factor);
    }
  }
  *out.mutable_fit_duration() = duration_from(std::chrono::duration_cast<Nanoseconds>(
      std::chrono::duration<double, std::micro>(judgement.fitted.fit_us)));
  for (const auto& warning : judgement.warnings) out.add_warnings(utf8_from(warning));
  return out;
}

}  // namespace

Result<application::MethodsRequest> methods_request_from(const v1::CompareMethodsRequest& request) {
  application::MethodsRequest asked;
  DRIFTWISE_TRY(auto fit, fit_request_from(request.fit(), FormulaIs::optional));
  asked.fit = std::move(fit);
  if (request.methods_size() > 4)
    return fail(
        ErrorCode::invalid_argument, reasons::kBadMethod,
        "methods: found " + std::to_string(request.methods_size()) + ", expected at most 4");
  asked.methods.assign(request.methods().begin(), request.methods().end());
  for (const auto& good : {check_size(request.robot_toml(), kMostRobotBytes, "robot_toml"),
                           check_size(request.together(), kMostNameBytes, "together")})
    DRIFTWISE_RETURN_IF_ERROR(good);
  asked.robot = request.robot_toml();
  asked.together = request.together();
  if (request.has_fold_count()) asked.folds = request.fold_count();
  if (asked.folds < 2 || asked.folds > 1000)
    return fail(ErrorCode::invalid_argument, reasons::kBadOption,
                "fold_count: found " + std::to_string(asked.folds) + ", expected 2 to 1000");
  return asked;
}

Result<application::SensorsRequest> sensors_request_from(const v1::StudySensorsRequest& request) {
  application::SensorsRequest asked;
  DRIFTWISE_TRY(auto fit, fit_request_from(request.fit()));
  asked.fit = std::move(fit);
  if (request.has_tolerance()) asked.tolerance = request.tolerance();
  if (!(asked.tolerance >= 0 && asked.tolerance <= 10))  // false for NaN
    return fail(ErrorCode::invalid_argument, reasons::kBadOption,
                "tolerance: found " + formats::number_text(asked.tolerance) + ", expected 0 to 10");
  return asked;
}

v1::CompareMethodsResponse comparison_from(const std::vector<identification::Judgement>& judgements,
                                           const std::string& formula) {
  v1::CompareMethodsResponse out;
  for (const auto& judgement : judgements) *out.add_methods() = outcome_from(judgement);
  out.set_json(utf8_from(formats::comparison_json(judgements, formula).dump()));
  out.set_table(utf8_from(formats::comparison_table(judgements)));
  return out;
}

v1::StudySensorsResponse sensor_choice_from(const application::SensorChoice& choice) {
  v1::StudySensorsResponse out;
  const auto& study = choice.study;
  const auto summary = summary_unit(choice.unit);
  for (const auto& set : study.best) {
    auto& one = *out.add_best();
    one.mutable_sensors()->Add(set.sensors.begin(), set.sensors.end());
    for (const auto& figure : set.outputs) {
      auto& output = *one.add_outputs();
      output.set_output(figure.output);
      output.set_u90_blocks(figure.u90_blocks * summary.factor);
      output.set_mean_blocks(figure.mean_blocks * summary.factor);
      output.set_a90_blocks(figure.a90_blocks * summary.factor);
      if (figure.u90_validation) output.set_u90_validation(*figure.u90_validation * summary.factor);
      if (figure.mean_validation)
        output.set_mean_validation(*figure.mean_validation * summary.factor);
      if (figure.a90_validation) output.set_a90_validation(*figure.a90_validation * summary.factor);
    }
    one.set_u90_blocks_rms(set.u90_blocks_rms * summary.factor);
    one.set_a90_blocks_rms(set.a90_blocks_rms * summary.factor);
    if (set.u90_validation_rms)
      one.set_u90_validation_rms(*set.u90_validation_rms * summary.factor);
    if (set.a90_validation_rms)
      one.set_a90_validation_rms(*set.a90_validation_rms * summary.factor);
  }
  out.set_recommended(static_cast<int>(study.recommended));
  out.set_tried_set_count(static_cast<std::int64_t>(study.sets_tried));
  out.set_tolerance(study.tolerance);
  out.set_unit(summary.unit);
  return out;
}

}  // namespace driftwise::rpc
