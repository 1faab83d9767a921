#include "tests/hidden_effects/plants/plant_accept.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tests/hidden_effects/accepting/served_truth.h"

namespace driftwise::hidden {
namespace {

constexpr CellTime kZeroTime{1'600'000'000'000'000'000};  // that of plant_run
constexpr double kSigmasOf90 = 1.645;

template <class T>
T must(Result<T> result, const char* what) {
  if (!result) throw std::runtime_error(std::string(what) + ": " + result.error().message);
  return std::move(*result);
}

// Validation rows, from the zero of the datum on.
TrueRows truth_of(const PlantRun& run, std::size_t outputs) {
  TrueRows truth;
  truth.time_zero = kZeroTime;
  truth.time_s = run.data.time_s;
  for (std::size_t axis = 0; axis < run.true_mm.size(); ++axis)
    truth.asked.push_back({static_cast<compensation::Variable>(axis), run.true_mm[axis]});
  if (const auto force = run.data.values_of("force"); !force.empty())
    truth.asked.push_back({compensation::Variable::force, {force.begin(), force.end()}});
  for (std::size_t o = 0; o < outputs; ++o) {
    const auto motor = run.data.values_of("q" + std::to_string(o + 1));
    truth.motor_mm.emplace_back(motor.begin(), motor.end());
  }
  for (std::size_t row = 0; row < run.data.rows; ++row)
    truth.judged.push_back(run.data.set_of(row) == PointSet::validation ? 1 : 0);
  truth.zero_motor_mm = run.zero_q_mm;
  return truth;
}

}  // namespace

double u90_at_truth(const std::vector<double>& errors) { return kSigmasOf90 * rms_of(errors); }

HarmRatio harm_of(const std::vector<AcceptedOnPlant>& plants, std::size_t output) {
  std::vector<double> ratios;
  for (const auto& plant : plants)
    ratios.push_back(rms_of(plant.outputs[output].after_nm) /
                     rms_of(plant.outputs[output].before_nm));
  const auto interval = mean_ratio(ratios, 0.90);
  return {interval.mean, interval.low};
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
  const auto errors = [&](const calibration::Model& model, const PlantRun& of) {
    return served_errors(model, cell, of.data, truth_of(of, model.outputs.size()));
  };
  const auto model = must(accepted_fit(run.data, one.baseline), "baseline");
  const auto before = must(errors(model, run), "baseline").nm;
  const auto best =
      must(errors(must(accepted_fit(nothing_hidden.data, one.baseline), "clean"), nothing_hidden),
           "clean")
          .nm;
  const auto found = diagnosed_case(one, run.data, nulls);

  AcceptedOnPlant result;
  result.named = names_of(found);
  result.formula = one.baseline;
  auto after = before;
  if (auto made = accept_all(found, run.data, kZeroTime); !made) {
    result.refused = made.error().message;
  } else if (auto served = errors(made->model, run); !served) {
    result.refused = served.error().message;
  } else {
    after = std::move(served->nm);
    result.formula = made->plan.formula;
    for (const auto& shift : made->plan.amendment.shifts) result.shifted.push_back(shift.axis);
  }
  for (std::size_t o = 0; o < before.size(); ++o)
    result.outputs.push_back({model.outputs[o].channel.symbol, before[o], after[o], best[o]});
  return result;
}

}  // namespace driftwise::hidden
