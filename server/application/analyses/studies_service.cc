#include "server/application/analyses/studies_service.h"

#include <fmt/format.h>

#include "server/application/models/fit_options.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/cell_file/kinematics_section.h"
#include "server/formats/formula/formula.h"
#include "server/kinematics/mechanism.h"

namespace driftwise::application {
namespace {

using identification::Judgement;
using identification::Method;

// The fit's options with the formula's candidates, where there is a formula.
Result<calibration::FitOptions> options_with_candidates(const FitRequest& request,
                                                        const Dataset& data) {
  auto options = fit_options_from(request, data, source_of(request));
  if (!options || request.formula.empty()) return options;
  DRIFTWISE_TRY(const auto formula, formats::Formula::parse(request.formula));
  DRIFTWISE_TRY(auto candidates, formula.expand(data));
  options->candidates = std::move(candidates);
  return options;
}

Result<std::vector<Method>> methods_of(const MethodsRequest& request, bool has_geometry) {
  std::vector<Method> methods;
  for (const auto& name : request.methods) {
    const auto method = identification::method_from(name);
    if (!method)
      return fail(
          ErrorCode::invalid_argument, reasons::kBadMethod,
          fmt::format("found method '{}', expected nominal, classic, kinematic or stepwise", name));
    methods.push_back(*method);
  }
  if (methods.empty())
    methods = identification::methods_possible(!request.fit.formula.empty(), has_geometry);
  if (methods.empty())
    return fail(ErrorCode::invalid_argument, reasons::kNoMethod,
                "compare what? neither a formula is given, nor a robot file, and the cell file has "
                "no [kinematics]");
  return methods;
}

Result<std::vector<Judgement>> judged(const Dataset& data, const MethodsRequest& request,
                                      const std::optional<KinematicsDescription>& geometry,
                                      StudyBench& bench) {
  identification::MethodOptions options;
  DRIFTWISE_TRY(auto fit, options_with_candidates(request.fit, data));
  options.fit = std::move(fit);
  options.fit.executor = bench.sharing(request.fit.threads);
  if (geometry) {
    DRIFTWISE_TRY(auto mechanism, kinematics::make_mechanism(*geometry));
    options.mechanism = std::move(mechanism);
  }
  DRIFTWISE_TRY(const auto methods, methods_of(request, options.mechanism != nullptr));
  identification::JudgeOptions judge;
  judge.blocks = request.fit.blocks;
  judge.together = request.together;
  judge.folds = request.folds;
  std::vector<Judgement> judgements;
  for (const Method method : methods) {
    const auto count = methods.size(), number = judgements.size() + 1;
    bench.say(static_cast<double>(number - 1) / static_cast<double>(count),
              fmt::format("{}, {} of {}", identification::name_of(method), number, count));
    DRIFTWISE_TRY(auto judgement, identification::judge_method(data, method, options, judge));
    judgements.push_back(std::move(judgement));
  }
  return judgements;
}

}  // namespace

Awaitable<Result<std::vector<Judgement>>> StudiesService::compare_methods(
    MethodsRequest request, std::shared_ptr<Study> study) {
  auto geometry = description_.kinematics;
  if (!request.robot.empty()) {
    DRIFTWISE_CO_TRY(auto given, formats::parse_robot_file(request.robot, "robot file"));
    geometry = std::move(given);
  }
  auto loading = datasets_.load(request.fit.runs, request.fit.csv);
  DRIFTWISE_CO_TRY(auto dataset, co_await std::move(loading));
  std::function<Result<std::vector<Judgement>>(StudyBench&)> work =
      [data = std::move(dataset), request, geometry](StudyBench& bench) {
        return judged(data, request, geometry, bench);
      };
  auto studying = desk_.carry_out(std::move(study), std::move(work));
  co_return co_await std::move(studying);
}

Awaitable<Result<SensorChoice>> StudiesService::study_sensors(SensorsRequest request,
                                                              std::shared_ptr<Study> study) {
  auto loading = datasets_.load(request.fit.runs, request.fit.csv);
  DRIFTWISE_CO_TRY(auto dataset, co_await std::move(loading));
  std::function<Result<SensorChoice>(StudyBench&)> work =
      [data = std::move(dataset), request](StudyBench& bench) -> Result<SensorChoice> {
    DRIFTWISE_TRY(auto options, options_with_candidates(request.fit, data));
    options.stopwatch_us = {};
    options.executor = bench.counting(request.fit.threads, "trying sets of thermometers");
    DRIFTWISE_TRY(auto found, calibration::study_sensors(data, options, request.tolerance));
    const auto* output = data.find(found.best.front().outputs.front().output);
    return SensorChoice{std::move(found), output->channel.unit};
  };
  auto studying = desk_.carry_out(std::move(study), std::move(work));
  co_return co_await std::move(studying);
}

}  // namespace driftwise::application
