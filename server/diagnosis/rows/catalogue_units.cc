#include "server/diagnosis/rows/catalogue_units.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "server/core/unit_conversion.h"
#include "server/effects/effect.h"

namespace driftwise::diagnosis {
namespace {

std::string catalogue_unit(const Channel& channel) {
  const bool coordinate = is_motor_symbol(channel.symbol) || is_pose_symbol(channel.symbol);
  if (coordinate && is_length(channel.unit)) return "mm";
  if (coordinate && is_angle(channel.unit)) return "arcsec";
  if (channel.unit == "K") return "degC";
  if (channel.unit == "Pa") return "hPa";
  return channel.unit;
}

// Of one unit of the user's column, in the catalogue's unit.
double factor_of(const Channel& channel) {
  const auto unit = catalogue_unit(channel);
  if (unit == channel.unit) return 1;
  const auto conversion = unit_conversion(channel.unit, unit);
  return conversion ? conversion->factor / conversion->divisor : 1;
}

}  // namespace

Dataset in_catalogue_units(const Dataset& dataset) {
  Dataset result = dataset;
  for (auto& column : result.columns) {
    const auto unit = catalogue_unit(column.channel);
    if (unit == column.channel.unit) continue;
    const auto conversion = unit_conversion(column.channel.unit, unit);
    if (!conversion) continue;
    for (double& value : column.values) value = (*conversion)(value);
    column.channel.unit = unit;
  }
  return result;
}

calibration::Candidates in_catalogue_units(const calibration::Candidates& baseline) {
  calibration::Candidates result = baseline;
  for (auto& term : result.terms)
    for (auto& factor : term.factors) {
      auto* call = std::get_if<effects::Call>(&factor);
      const auto* kind = call == nullptr ? nullptr : effects::find_effect(call->effect);
      if (kind == nullptr || !kind->of_coordinate) continue;
      const bool angle = std::ranges::any_of(
          call->parameters, [](const effects::Quantity& one) { return is_angle(one.unit); });
      if (auto made = effects::for_coordinate_in(angle ? "arcsec" : "mm", *call)) *call = *made;
    }
  return result;
}

double coefficient_factor(const Dataset& dataset, const effects::Term& term,
                          const std::string& output) {
  double factor = 1;
  if (const auto* column = dataset.find(output)) factor /= factor_of(column->channel);
  for (const auto& one : term.factors) {
    const auto* power = std::get_if<effects::Power>(&one);
    const auto* call = std::get_if<effects::Call>(&one);
    if (call != nullptr && call->symbols.empty()) continue;
    const auto* column = dataset.find(power != nullptr ? power->symbol : call->symbols.front());
    if (column == nullptr) continue;
    const auto* kind = call == nullptr ? nullptr : effects::find_effect(call->effect);
    if (power != nullptr)
      factor *= std::pow(factor_of(column->channel), power->exponent);
    else if (kind != nullptr && kind->output_unit.starts_with("mm"))
      factor *= factor_of(column->channel);
  }
  return factor;
}

}  // namespace driftwise::diagnosis
