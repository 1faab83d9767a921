#include "server/formats/model/coefficient_unit.h"

#include <algorithm>
#include <string>
#include <vector>

#include "server/effects/effect.h"
#include "server/effects/term_order.h"

namespace driftwise::formats {
namespace {

std::string unit_of(const std::string& symbol, const calibration::Model& model) {
  for (const auto& range : model.domain)
    if (range.channel.symbol == symbol) return range.channel.unit;
  return "";
}

// Unit that a coefficient is "per", each factor once with its power: mm/mm^3 of x:y:z.
class Divisor {
 public:
  void multiply(const std::string& unit, int exponent) {
    const auto at = std::ranges::find(parts_, unit, &Part::unit);
    if (at == parts_.end())
      parts_.push_back({unit, exponent});
    else
      at->exponent += exponent;
  }
  std::string text() const {
    std::string text;
    for (const auto& part : parts_) {
      text += (text.empty() ? "" : " ") + part.unit;
      if (part.exponent > 1) text += "^" + std::to_string(part.exponent);
    }
    return parts_.size() > 1 ? "(" + text + ")" : text;
  }

 private:
  struct Part {
    std::string unit;
    int exponent;
  };
  std::vector<Part> parts_;
};

// "mm", or "(mm/s)" where it is more than one unit.
std::string one_unit(const std::string& unit) {
  return unit.find_first_of(" /^*") == std::string::npos ? unit : "(" + unit + ")";
}

}  // namespace

std::string coefficient_unit(const calibration::OutputModel& output, const effects::Term& term,
                             const calibration::Model& model) {
  Divisor below;
  for (const auto& factor : term.factors) {
    if (const auto* power = std::get_if<effects::Power>(&factor)) {
      const std::string unit = unit_of(power->symbol, model);
      if (unit.empty()) return {};
      if (unit != "1") below.multiply(unit, power->exponent);
      continue;
    }
    const auto& call = std::get<effects::Call>(factor);
    const auto* kind = effects::find_effect(call.effect);
    if (kind == nullptr) continue;
    const std::string of_channel = call.symbols.empty() ? "" : unit_of(call.symbols.front(), model);
    // "^2", "^(2/3)": a power of the channel's own unit.
    const std::string& own = kind->output_unit;
    const bool is_power = own.empty() || own.front() == '^';
    const std::string unit =
        is_power ? of_channel : one_unit(effects::output_unit(*kind, of_channel));
    if (unit.empty() || unit == "1") continue;
    if (is_power && own == "^2")
      below.multiply(unit, 2);
    else
      below.multiply(is_power ? unit + own : unit, 1);
  }
  const std::string divisor = below.text();
  return output.channel.unit + (divisor.empty() ? "" : "/" + divisor);
}

}  // namespace driftwise::formats
