#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "server/core/channel.h"
#include "server/core/reasons.h"
#include "server/core/units.h"
#include "server/effects/beam.h"
#include "server/effects/contact.h"
#include "server/effects/creep.h"
#include "server/effects/data_time.h"
#include "server/effects/effect.h"
#include "server/effects/lag.h"
#include "server/effects/periodic.h"
#include "server/effects/play.h"
#include "server/effects/self_heating.h"
#include "server/effects/term_order.h"
#include "server/effects/thermal_rate.h"

namespace driftwise::effects {
namespace {

// value x 10^shift, correctly rounded: 0.3164 um is 316.4 nm, not 316.40000000000003.
double shifted(double value, int shift) {
  std::string text = number_text(value);
  if (const auto e = text.find('e'); e != std::string::npos) {
    shift += std::stoi(text.substr(e + 1));
    text.resize(e);
  }
  text += "e" + std::to_string(shift);
  double result = value;
  std::from_chars(text.data(), text.data() + text.size(), result);
  return result;
}

struct Scale {
  const char* from;
  const char* to;
  double factor;
  int shift;  // ... and this power of ten
};
constexpr std::array<Scale, 9> kScales = {{{"ms", "s", 1, -3},
                                           {"min", "s", 60, 0},
                                           {"h", "s", 3600, 0},
                                           {"d", "s", 86400, 0},
                                           {"um", "nm", 1, 3},
                                           {"mm", "nm", 1, 6},
                                           {"m", "nm", 1, 9},
                                           {"deg", "arcsec", 3600, 0},
                                           {"rad", "arcsec", 1 / kRadPerArcsec, 0}}};

constexpr const char* kAngleUnit = "arcsec";

// "5 min" -> 300 in "s"; NaN when the unit is of another kind.
double converted(const Quantity& quantity, const std::string& unit) {
  if (quantity.unit == unit || !std::isfinite(quantity.value)) return quantity.value;
  for (const auto& scale : kScales)
    if (quantity.unit == scale.from && unit == scale.to)
      return shifted(quantity.value * scale.factor, scale.shift);
  return std::nan("");
}

// Of nm or arcsec into another unit of the kind.
double from_smallest(double value, const std::string& unit) {
  for (const auto& scale : kScales)
    if (unit == scale.from) return shifted(value / scale.factor, -scale.shift);
  return value;
}

std::string unit_beside(const std::string& coordinate) {
  if (coordinate == "mm") return "nm";
  return coordinate == "nm" ? "mm" : coordinate;
}

}  // namespace

std::span<const EffectKind> effect_kinds() {
  static const std::vector<EffectKind> kinds = {
      lag_kind(),          thermal_rate_kind(),   thermal_rate2_kind(), play_kind(),
      creep_kind(),        self_heating_kind(),   sine_kind(),          cosine_wave_kind(),
      sine_in_time_kind(), cosine_in_time_kind(), step_kind(),          drift_kind(),
      cosine_error_kind(), air_index_kind(),      square_lag_kind(),    contact_kind()};
  return kinds;
}

std::string_view to_string(AppliesTo applies_to) {
  switch (applies_to) {
    case AppliesTo::robot:
      return "robot";
    case AppliesTo::correction:
      return "correction";
    case AppliesTo::dataset:
      return "dataset";
  }
  return "";
}

const EffectKind* find_effect(std::string_view name) {
  for (const auto& kind : effect_kinds())
    if (kind.name == name) return &kind;
  return nullptr;
}

std::string usage(const EffectKind& kind) {
  std::string text = kind.name + "(";
  for (int i = 0; i < kind.symbol_count; ++i) {
    const std::string one = i == 0 ? "channel" : ", channel";
    text += i < kind.symbol_count - kind.optional_symbols ? one : "[" + one + "]";
  }
  for (const auto& parameter : kind.parameters)
    text += (text.back() == '(' ? "" : ", ") + parameter.name +
            (parameter.unit.empty() ? "" : " " + parameter.unit);
  return text + ")";
}

Result<Call> for_coordinate_in(const std::string& unit, const Call& call) {
  const auto bad = [](std::string why) {
    return fail(ErrorCode::invalid_argument, reasons::kBadUnit, std::move(why));
  };
  const EffectKind& kind = *find_effect(call.effect);
  if (!is_length(unit) && !is_angle(unit))
    return bad("expected a channel of lengths (m, mm, um, nm) or angles (rad, deg, arcsec)");
  Call result = call;
  for (std::size_t i = 0; i < kind.parameters.size(); ++i) {
    if (kind.parameters[i].max_arcsec == 0) continue;
    const auto& given = call.parameters[i];
    if (is_angle(given.unit) != is_angle(unit))
      return bad("its " + kind.parameters[i].name + " is in " + given.unit + ", expected " +
                 (is_angle(unit) ? kAngleUnit : kind.parameters[i].unit) +
                 " as the channel is in " + unit);
    const std::string beside = unit_beside(unit);
    if (given.unit == beside) continue;
    const std::string smallest = is_angle(unit) ? kAngleUnit : "nm";
    result.parameters[i] = {from_smallest(converted(given, smallest), beside), beside};
  }
  return result;
}

double in_unit_of_channel(const Quantity& parameter) {
  if (parameter.unit == "nm") return mm_from_nm(parameter.value);
  return parameter.unit == "mm" ? nm_from_mm(parameter.value) : parameter.value;
}

std::string output_unit(const EffectKind& kind, const std::string& unit) {
  if (!kind.of_coordinate || unit == "mm" || !kind.output_unit.starts_with("mm"))
    return kind.output_unit;
  return unit + kind.output_unit.substr(2);
}

Result<Call> checked(const Call& call) {
  const auto bad = [&call](std::string why) {
    return fail(ErrorCode::invalid_argument, reasons::kBadEffect,
                notation(Factor(call)) + ": " + std::move(why));
  };
  const EffectKind* kind = find_effect(call.effect);
  if (kind == nullptr) {
    std::string known;
    for (const auto& one : effect_kinds()) known += (known.empty() ? "" : ", ") + usage(one);
    return fail(ErrorCode::invalid_argument, reasons::kUnknownEffect,
                "unknown effect '" + call.effect + "': known are " + known);
  }
  const auto given = static_cast<int>(call.symbols.size());
  if (given > kind->symbol_count || given < kind->symbol_count - kind->optional_symbols ||
      call.parameters.size() != kind->parameters.size())
    return bad("expected " + usage(*kind));
  Call result = call;
  for (std::size_t i = 0; i < kind->parameters.size(); ++i) {
    const auto& parameter = kind->parameters[i];
    std::string unit = parameter.unit;
    double value = converted(call.parameters[i], unit), min = parameter.min, max = parameter.max;
    const bool of_coordinate = parameter.max_arcsec > 0;
    if (std::isnan(value) && of_coordinate) {
      unit = kAngleUnit;
      value = converted(call.parameters[i], unit);
      min = parameter.min_arcsec;
      max = parameter.max_arcsec;
    }
    if (std::isnan(value))
      return bad(parameter.name + " is in '" + call.parameters[i].unit + "', expected " +
                 parameter.unit + (of_coordinate ? " or arcsec" : ""));
    if (!(value >= min && value <= max))
      return bad(parameter.name + " is " + number_text(value) + " " + unit + ", expected " +
                 number_text(min) + " to " + number_text(max) + " " + unit);
    if (!of_coordinate) result.parameters[i] = {value, unit};
  }
  return result;
}

}  // namespace driftwise::effects
