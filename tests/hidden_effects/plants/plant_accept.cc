#include "tests/hidden_effects/plants/plant_accept.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "server/application/diagnoses/extension_plan.h"
#include "server/application/models/fit_options.h"
#include "server/compensation/snapshot_builder.h"
#include "server/compensation/target.h"
#include "server/core/channel.h"
#include "server/core/try.h"
#include "server/core/units.h"
#include "server/formats/model/model_json.h"

namespace driftwise::hidden {
namespace {

constexpr CellTime kZeroTime{1'600'000'000'000'000'000};  // that of plant_run
constexpr RunId kOnlyRun{1};
constexpr double kSigmasOf90 = 1.645;

template <class T>
T must(Result<T> result, const char* what) {
  if (!result) throw std::runtime_error(std::string(what) + ": " + result.error().message);
  return std::move(*result);
}

application::RunsData runs_data(const PlantRun& run) {
  application::RunsData data{run.data, {}, kZeroTime};
  for (std::size_t row = 0; row < run.data.rows; ++row)
    data.origins.push_back({kOnlyRun, static_cast<std::int64_t>(row)});
  return data;
}

// As the daemon fits what it accepts.
Result<calibration::Model> fitted(const Dataset& data, const std::string& formula) {
  application::FitRequest fit;
  fit.runs = {kOnlyRun};
  fit.formula = formula;
  fit.select = "all";
  auto record = application::fit_record(data, fit, application::source_of(fit));
  if (!record && record.error().reason == "RANK_DEFICIENT") {
    fit.select = "stepwise";
    record = application::fit_record(data, fit, application::source_of(fit));
  }
  DRIFTWISE_RETURN_IF_ERROR(record);
  return formats::read_model_json(record->json);
}

// Per output, of every validation row in time order: served target minus what the scale read, nm.
Result<std::vector<std::vector<double>>> errors_at_truth(const calibration::Model& model,
                                                         const CellDescription& cell,
                                                         const PlantRun& run) {
  DRIFTWISE_TRY(auto builder, compensation::SnapshotBuilder::create(model, ModelId{1}, cell));
  std::vector<std::vector<double>> errors(model.outputs.size());
  for (std::size_t row = 0; row < run.data.rows; ++row) {
    const CellTime at = kZeroTime + nanoseconds_from_s(run.data.time_s[row]);
    std::vector<ChannelValue> seen;
    for (const auto& column : run.data.columns)
      if (!is_pose_symbol(column.channel.symbol))
        seen.push_back({column.channel.name(), column.values[row]});
    builder.observe(seen, at);
    if (row == 0) {  // seconds after the zero: its temperatures
      for (std::size_t k = 0; k < run.zero_q_mm.size(); ++k)
        for (auto& value : seen)
          if (value.channel == "q" + std::to_string(k + 1) + "_mm") value.value = run.zero_q_mm[k];
      DRIFTWISE_RETURN_IF_ERROR(builder.anchor(seen));
    }
    if (run.data.set_of(row) != PointSet::validation) continue;
    compensation::TargetRequest asked;
    for (std::size_t axis = 0; axis < run.true_mm.size(); ++axis)
      asked.set(static_cast<compensation::Variable>(axis), run.true_mm[axis][row]);
    if (const auto force = run.data.values_of("force"); !force.empty())
      asked.set(compensation::Variable::force, force[row]);
    const auto snapshot = builder.build(at);
    const auto target = compensation::compute_target(snapshot, asked);
    if (target.refusal != compensation::Refusal::none)
      return tl::unexpected(compensation::refusal_error(snapshot, target));
    for (std::size_t o = 0; o < target.outputs; ++o)
      errors[o].push_back(
          nm_from_mm(target.q_mm[o] - run.data.values_of(model.outputs[o].channel.symbol)[row]));
  }
  return errors;
}

std::string names_of(const diagnosis::Diagnosis& found) {
  std::string text;
  for (const auto& finding : found.findings)
    text += (text.empty() ? "" : " + ") + finding.cause +
            (finding.subject.empty() ? "" : " " + finding.subject);
  return text;
}

struct Made {
  application::ExtensionPlan plan;
  calibration::Model model;
};

Result<Made> accepted(const diagnosis::Diagnosis& found, const PlantRun& run) {
  std::vector<int> all(found.findings.size());
  std::iota(all.begin(), all.end(), 1);
  std::erase_if(all, [&](int number) {  // what cannot be accepted, as the daemon leaves it out
    return diagnosis::correction_is_uncertain(found.findings[static_cast<std::size_t>(number - 1)]);
  });
  if (all.empty()) return fail(ErrorCode::failed_precondition, "NOTHING_FOUND", "nothing to make");
  DRIFTWISE_TRY(auto chosen, application::chosen_findings(found, all));
  auto data = runs_data(run);
  DRIFTWISE_TRY(auto plan, application::plan_extension(DiagnosisId{1}, found, chosen, data));
  DRIFTWISE_RETURN_IF_ERROR(application::put_in_force(plan, data));
  DRIFTWISE_TRY(auto model, fitted(data.data, plan.formula));
  return Made{std::move(plan), std::move(model)};
}

}  // namespace

double u90_at_truth(const std::vector<double>& errors) {
  const double sum = std::inner_product(errors.begin(), errors.end(), errors.begin(), 0.0);
  return kSigmasOf90 *
         std::sqrt(sum / static_cast<double>(std::max<std::size_t>(errors.size(), 1)));
}

HarmRatio harm_of(const std::vector<AcceptedOnPlant>& plants, std::size_t output) {
  std::vector<double> logs;
  for (const auto& plant : plants)
    logs.push_back(std::log(u90_at_truth(plant.outputs[output].after_nm) /
                            u90_at_truth(plant.outputs[output].before_nm)));
  const auto n = static_cast<double>(logs.size());
  const double mean = std::accumulate(logs.begin(), logs.end(), 0.0) / n;
  double square = 0;
  for (const double one : logs) square += (one - mean) * (one - mean);
  const double se = std::sqrt(square / (n - 1) / n);
  const double t = boost::math::quantile(boost::math::students_t(n - 1), 0.95);
  return {std::exp(mean), std::exp(mean - t * se)};
}

std::vector<PlantCase> instrument_cases() {
  std::vector<PlantCase> cases;
  for (const char* name :
       {"axis.fringes", "axis.laser", "axis.lost_fringe", "axis.level", "axis.dead_path",
        "micro.lost_fringe", "micro.beam_place", "micro.beam_angle", "micro.laser"})
    for (const auto& one : plant_cases())
      if (one.name == name) cases.push_back(one);
  return cases;
}

AcceptedOnPlant accepted_on_plant(const PlantCase& one, std::uint64_t seed, int nulls) {
  const auto cell = cell_of(one);
  const auto run = run_case(one, seed);
  auto clean = one;
  clean.overrides.clear();
  const auto nothing_hidden = run_case(clean, seed);
  const auto model = must(fitted(run.data, one.baseline), "baseline");
  const auto before = must(errors_at_truth(model, cell, run), "baseline");
  const auto best = must(errors_at_truth(must(fitted(nothing_hidden.data, one.baseline), "clean"),
                                         cell, nothing_hidden),
                         "clean");
  const auto found = diagnosed_case(one, run.data, nulls);

  AcceptedOnPlant result;
  result.named = names_of(found);
  result.formula = one.baseline;
  auto after = before;
  if (auto made = accepted(found, run); !made) {
    result.refused = made.error().message;
  } else if (auto errors = errors_at_truth(made->model, cell, run); !errors) {
    result.refused = errors.error().message;
  } else {
    after = std::move(*errors);
    result.formula = made->plan.formula;
    for (const auto& shift : made->plan.amendment.shifts) result.shifted.push_back(shift.axis);
  }
  for (std::size_t o = 0; o < before.size(); ++o)
    result.outputs.push_back({model.outputs[o].channel.symbol, before[o], after[o], best[o]});
  return result;
}

}  // namespace driftwise::hidden
