#pragma once
// Effects: mechanisms with a notation, bounds and, where they need it, memory. One file pair per
// mechanism; the list of all of them is registry.cc.

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/result.h"
#include "server/effects/term.h"

namespace driftwise::effects {

// The memory of one effect: a fold over a stream of time-stamped values.
class EffectState {
 public:
  virtual ~EffectState() = default;
  virtual std::unique_ptr<EffectState> clone() const = 0;

  // time_s: seconds, not before the previous call's; inputs: the value of each symbol of the call,
  // in its order. Result: the effect's output at time_s. A missing input (NaN) gives NaN and leaves
  // the memory as it was, so the next step spans the gap. The first value starts the memory in
  // equilibrium with it.
  virtual double step(double time_s, std::span<const double> inputs) = 0;
};

struct ParameterKind {
  std::string name;  // "tau"
  std::string unit;  // "s": what the canonical notation uses; "" for a plain number
  double min = 0, max = 0;
  // Of a coordinate that is an angle: arcsec from, to; 0: of a length or a time only.
  double min_arcsec = 0, max_arcsec = 0;
};

// Where an effect's finding goes (DESIGN: where an effect applies): the served model, the
// correction of an instrument, or the data themselves.
enum class AppliesTo { robot, correction, dataset };
std::string_view to_string(AppliesTo applies_to);

struct EffectKind {
  std::string name;          // "rate", as written in a formula
  std::string catalogue_id;  // "thermal_rate"
  int symbol_count = 1;      // channels it observes
  int optional_symbols = 0;  // of them, the last ones, that may be left out
  std::vector<ParameterKind> parameters;
  std::string
      output_unit;  // after the channel's own unit: "K/h"; "" for the unit of the channel itself
  std::string sentence;  // what a person reads in --help
  std::unique_ptr<EffectState> (*make)(std::span<const Quantity> parameters) = nullptr;
  AppliesTo applies_to = AppliesTo::robot;
  // The unit each observed channel must have, in order; empty: any.
  std::vector<std::string> channel_units{};
  // Its output is the deviation that the path of a motor coordinate leaves behind, so it may stand
  // among that coordinate's own terms.
  bool observes_path = false;
  // Reads the data's own clock (an instant, a phase): means nothing to a target asked for later.
  bool in_data_time = false;
  // A function of its channels at the same instant: asks for no time.
  bool memoryless = false;
  // Its first channel is a coordinate, a length in any unit or an angle in any; a parameter in nm
  // is then one in arcsec, and an output in mm is in the channel's unit.
  bool of_coordinate = false;
};

// The same call for a first channel in `unit`. A coordinate's effect sees bare numbers, so its
// parameters are in the unit that goes with the channel's: nm for mm and mm for nm, else the
// channel's own. Errors: invalid_argument BAD_UNIT (a period in nm of an angle; a channel in degC).
Result<Call> for_coordinate_in(const std::string& unit, const Call& call);
// Value of such a parameter in the unit of the channel.
double in_unit_of_channel(const Quantity& parameter);
// Unit of the output where the first channel is in `unit`.
std::string output_unit(const EffectKind& kind, const std::string& unit);

std::span<const EffectKind> effect_kinds();
const EffectKind* find_effect(std::string_view name);

// Counts, units and bounds. Parameters may come in another unit of the same kind ("5 min"): the
// call returned has them in the kind's own, but for a coordinate's, which stay as they are: their
// unit is the channel's affair (for_coordinate_in). Errors: invalid_argument UNKNOWN_EFFECT (names
// the known ones), BAD_EFFECT (what was expected).
Result<Call> checked(const Call& call);

// "rate(t, tau s)": how it is written, for messages.
std::string usage(const EffectKind& kind);

}  // namespace driftwise::effects
