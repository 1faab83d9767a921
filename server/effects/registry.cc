#include <algorithm>
#include <array>
#include <cmath>

#include "server/effects/beam.h"
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

// "5 min" -> 300 in "s"; NaN when the unit is of another kind.
double converted(const Quantity& quantity, const std::string& unit) {
  struct Scale {
    const char* from;
    const char* to;
    double factor;
  };
  static constexpr std::array<Scale, 7> scales = {{{"ms", "s", 1e-3},
                                                   {"min", "s", 60},
                                                   {"h", "s", 3600},
                                                   {"d", "s", 86400},
                                                   {"um", "nm", 1e3},
                                                   {"mm", "nm", 1e6},
                                                   {"m", "nm", 1e9}}};
  if (quantity.unit == unit) return quantity.value;
  for (const auto& scale : scales)
    if (quantity.unit == scale.from && unit == scale.to) return quantity.value * scale.factor;
  return std::nan("");
}

}  // namespace

std::span<const EffectKind> effect_kinds() {
  static const std::vector<EffectKind> kinds = {
      lag_kind(),          thermal_rate_kind(),   thermal_rate2_kind(), play_kind(),
      creep_kind(),        self_heating_kind(),   sine_kind(),          cosine_wave_kind(),
      sine_in_time_kind(), cosine_in_time_kind(), step_kind(),          drift_kind(),
      cosine_error_kind(), air_index_kind()};
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
  for (int i = 0; i < kind.symbol_count; ++i) text += i == 0 ? "channel" : ", channel";
  for (const auto& parameter : kind.parameters)
    text += (text.back() == '(' ? "" : ", ") + parameter.name +
            (parameter.unit.empty() ? "" : " " + parameter.unit);
  return text + ")";
}

Result<Call> checked(const Call& call) {
  const auto bad = [&call](std::string why) {
    return fail(ErrorCode::invalid_argument, "BAD_EFFECT",
                notation(Factor(call)) + ": " + std::move(why));
  };
  const EffectKind* kind = find_effect(call.effect);
  if (kind == nullptr) {
    std::string known;
    for (const auto& one : effect_kinds()) known += (known.empty() ? "" : ", ") + usage(one);
    return fail(ErrorCode::invalid_argument, "UNKNOWN_EFFECT",
                "unknown effect '" + call.effect + "': known are " + known);
  }
  if (call.symbols.size() != static_cast<std::size_t>(kind->symbol_count) ||
      call.parameters.size() != kind->parameters.size())
    return bad("expected " + usage(*kind));
  Call result = call;
  for (std::size_t i = 0; i < kind->parameters.size(); ++i) {
    const auto& parameter = kind->parameters[i];
    const double value = converted(call.parameters[i], parameter.unit);
    if (std::isnan(value))
      return bad(parameter.name + " is in '" + call.parameters[i].unit + "', expected " +
                 parameter.unit);
    if (!(value >= parameter.min && value <= parameter.max))
      return bad(parameter.name + " is " + number_text(value) + " " + parameter.unit +
                 ", expected " + number_text(parameter.min) + " to " + number_text(parameter.max) +
                 " " + parameter.unit);
    result.parameters[i] = {value, parameter.unit};
  }
  return result;
}

}  // namespace driftwise::effects
