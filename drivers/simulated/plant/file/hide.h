#pragma once
// driftwise-cellsim --hide: causes by the names that a diagnosis has for them -> mechanisms of the
// plant, with the sizes that were asked for or drawn. Names, ranges and sources:
// docs/plants/hidden.md.

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/simulated/plant/file/plant_file.h"

namespace driftwise::simulated {

struct HiddenCause {
  std::string cause;     // "backlash"
  std::string symbol;    // what it acts on or comes from: "q1", "t07", "x"
  double size = 0;       // in unit; the mechanism's own, so what the data show may be smaller
  std::string unit;      // "nm", "s", "ppm", "J/mm", ""
  std::string override;  // "hidden.h1={kind=...}", for read_plant_file
};

// wanted: "backlash:q1=80nm,thermal_lag:t07=1800s", a cause alone for its middle size, or "random":
// one or two causes that plan and room can show, drawn with the seed: never two on one symbol.
// Throws PlantFileError naming the item, what was found and what there is.
std::vector<HiddenCause> hide(const std::string& wanted, const PlantParameters& plant,
                              std::uint64_t seed);

// The answer to keep sealed until the finding stands: JSON, {"schema":"driftwise.hidden.v1",...}.
std::string hidden_answer_json(const std::vector<HiddenCause>& causes, std::uint64_t seed);

}  // namespace driftwise::simulated
