#include "server/calibration/sensor_sets.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include "server/core/reasons.h"
#include "server/effects/term_order.h"

namespace driftwise::calibration {
namespace {

std::vector<std::string> thermometers(const Dataset& dataset, const FitOptions& base) {
  std::vector<std::string> sensors;
  for (const auto& term : base.candidates.terms)
    for (const auto& symbol : effects::symbols_of(term)) {
      const auto* column = dataset.find(symbol);
      const bool left_out =
          std::ranges::find(base.exclude_channels, symbol) != base.exclude_channels.end();
      if (column != nullptr && is_structure_temperature(column->channel) && !left_out &&
          std::ranges::find(sensors, symbol) == sensors.end())
        sensors.push_back(symbol);
    }
  std::ranges::sort(sensors);
  return sensors;
}

// What a set cannot be ranked without.
Error no_figure(const Model& model, const std::string& output) {
  std::string reason = "there are fewer than three rows to a block";
  for (const auto& warning : model.warnings)
    if (warning.starts_with(output + ": no figure of held-out")) reason = warning;
  return {ErrorCode::failed_precondition, reasons::kNoBlocks,
          "sets of thermometers are ranked by blocks of time held out, and " + output +
              " has no such figure: " + reason + ". Measure more, or ask for fewer blocks"};
}

std::optional<SensorSet> tried(const Dataset& dataset, FitOptions options,
                               const std::vector<std::string>& all, std::uint32_t chosen,
                               Error* why) {
  SensorSet set;
  for (std::size_t i = 0; i < all.size(); ++i)
    (chosen >> i & 1 ? set.sensors : options.exclude_channels).push_back(all[i]);
  options.executor = {};  // the sets are what is shared out
  const auto model = fit(dataset, options);
  if (!model) {
    if (why != nullptr) *why = model.error();
    return std::nullopt;
  }
  double u90 = 0, a90 = 0, u90_validation = 0, a90_validation = 0;
  for (const auto& output : model->outputs) {
    const auto& accuracy = output.accuracy;
    if (!accuracy.a90_blocks) {
      if (why != nullptr) *why = no_figure(*model, output.channel.symbol);
      return std::nullopt;
    }
    set.outputs.push_back({output.channel.symbol, *accuracy.u90_blocks, *accuracy.mean_blocks,
                           *accuracy.a90_blocks, accuracy.u90_validation, accuracy.mean_validation,
                           accuracy.a90_validation});
    u90 += std::pow(*accuracy.u90_blocks, 2);
    a90 += std::pow(*accuracy.a90_blocks, 2);
    u90_validation += std::pow(accuracy.u90_validation.value_or(NAN), 2);
    a90_validation += std::pow(accuracy.a90_validation.value_or(NAN), 2);
  }
  const auto count = static_cast<double>(set.outputs.size());
  set.u90_blocks_rms = std::sqrt(u90 / count);
  set.a90_blocks_rms = std::sqrt(a90 / count);
  if (std::isfinite(a90_validation)) {
    set.u90_validation_rms = std::sqrt(u90_validation / count);
    set.a90_validation_rms = std::sqrt(a90_validation / count);
  }
  return set;
}

}  // namespace

Result<SensorStudy> study_sensors(const Dataset& dataset, const FitOptions& base,
                                  double tolerance) {
  const auto sensors = thermometers(dataset, base);
  if (sensors.empty())
    return fail(ErrorCode::invalid_argument, reasons::kNoSensors,
                "the formula offers no structure temperature tNN_degC: add T, or t04..t10");
  if (sensors.size() > kMostSensors)
    return fail(ErrorCode::invalid_argument, reasons::kTooManySensors,
                std::to_string(sensors.size()) + " thermometers make 2^" +
                    std::to_string(sensors.size()) + " sets, at most " +
                    std::to_string(kMostSensors) + " thermometers are studied: leave some out");
  if (base.blocks < 2)
    return fail(ErrorCode::invalid_argument, reasons::kNoBlocks,
                "sets are ranked by blocks of time held out: give at least 2 blocks");
  const DatasetColumn* first = nullptr;
  for (const auto& symbol : base.candidates.outputs) {
    const auto* column = dataset.find(symbol);
    if (column == nullptr) continue;
    if (first != nullptr && column->channel.unit != first->channel.unit)
      return fail(ErrorCode::invalid_argument, reasons::kUnitsDisagree,
                  "outputs in " + first->channel.unit + " and " + column->channel.unit +
                      " have no common figure to rank sets by: study each kind by itself");
    if (first == nullptr) first = column;
  }
  const std::size_t count = std::size_t{1} << sensors.size();
  std::vector<std::optional<SensorSet>> sets(count);
  Error why;
  sets[count - 1] = tried(dataset, base, sensors, static_cast<std::uint32_t>(count - 1), &why);
  if (!sets[count - 1]) return tl::unexpected(why);
  const auto job = [&](std::size_t chosen) {
    sets[chosen] = tried(dataset, base, sensors, static_cast<std::uint32_t>(chosen), nullptr);
  };
  if (base.executor)
    base.executor(count - 1, job);
  else
    for (std::size_t chosen = 0; chosen + 1 < count; ++chosen) job(chosen);

  SensorStudy study;
  study.sets_tried = count;
  study.tolerance = tolerance;
  for (std::size_t many = sensors.size() + 1; many-- > 0;) {
    const SensorSet* best = nullptr;
    for (std::size_t chosen = 0; chosen < count; ++chosen)
      if (sets[chosen] && static_cast<std::size_t>(std::popcount(chosen)) == many &&
          (best == nullptr || sets[chosen]->a90_blocks_rms < best->a90_blocks_rms))
        best = &*sets[chosen];
    if (best != nullptr) study.best.push_back(*best);
  }
  double lowest = INFINITY, lowest_validation = INFINITY;
  for (const auto& set : study.best) {
    lowest = std::min(lowest, set.a90_blocks_rms);
    lowest_validation = std::min(lowest_validation, set.a90_validation_rms.value_or(INFINITY));
  }
  for (std::size_t i = 0; i < study.best.size(); ++i)
    if (study.best[i].a90_blocks_rms <= (1 + tolerance) * lowest &&
        study.best[i].a90_validation_rms.value_or(0) <= (1 + tolerance) * lowest_validation)
      study.recommended = i;
  return study;
}

}  // namespace driftwise::calibration
