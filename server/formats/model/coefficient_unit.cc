#include "server/formats/model/coefficient_unit.h"

#include "server/effects/effect.h"
#include "server/effects/term_order.h"

namespace driftwise::formats {
namespace {

std::string unit_of(const std::string& symbol, const calibration::Model& model) {
  for (const auto& range : model.domain)
    if (range.channel.symbol == symbol) return range.channel.unit;
  return "";
}

}  // namespace

std::string coefficient_unit(const calibration::OutputModel& output, const effects::Term& term,
                             const calibration::Model& model) {
  std::string below;
  int parts = 0;
  for (const auto& factor : term.factors) {
    std::string unit;
    if (const auto* power = std::get_if<effects::Power>(&factor)) {
      unit = unit_of(power->symbol, model);
      if (unit.empty()) return {};
      if (unit == "1") continue;
      if (power->exponent > 1) unit += "^" + std::to_string(power->exponent);
    } else {
      const auto& call = std::get<effects::Call>(factor);
      const auto* kind = effects::find_effect(call.effect);
      if (kind == nullptr) continue;
      // "^2": a power of the channel's own unit.
      const bool of_channel = kind->output_unit.empty() || kind->output_unit.front() == '^';
      unit = call.symbols.empty() ? "" : unit_of(call.symbols.front(), model);
      if (!of_channel) unit = "(" + effects::output_unit(*kind, unit) + ")";
      if (unit.empty() || unit == "1" || unit == "(1)") continue;
      if (of_channel) unit += kind->output_unit;
    }
    below += (below.empty() ? "" : " ") + unit;
    ++parts;
  }
  if (below.empty()) return output.channel.unit;
  return output.channel.unit + "/" + (parts > 1 ? "(" + below + ")" : below);
}

}  // namespace driftwise::formats
