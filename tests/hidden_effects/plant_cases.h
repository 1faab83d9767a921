#pragma once
// What is hidden in the plants, and what a diagnosis should say of it.

#include <optional>
#include <string>
#include <vector>

#include "server/core/cell_description.h"
#include "server/core/trajectory.h"
#include "server/diagnosis/diagnosis.h"
#include "tests/hidden_effects/plant_run.h"

namespace driftwise::hidden {

struct PlantCase {
  std::string name;         // "axis.friction"
  bool micro_nano = false;  // else the linear axis
  std::vector<std::string> overrides{};
  std::string baseline;
  Trajectory (*plan)() = nullptr;
  // The nearest cause of the catalogue, by the mechanism's physics; "" for nothing, "unexplained"
  // for what is in no catalogue.
  std::string cause;
  // Subjects that name the place; empty: any. Neighbouring thermometers may stand for a part that
  // has none.
  std::vector<std::string> subjects{};
  std::string where{};  // "" for any
};

const std::vector<PlantCase>& plant_cases();
PlantRun run_case(const PlantCase& one, std::uint64_t seed);

struct PlantVerdict {
  bool exact = false;   // named, in the right place, and nothing else
  bool in_set = false;  // named, or in the indistinguishable set of what was named; nothing else
  bool wrong = false;   // something else was named
  std::string named;    // "backlash q1 + ..."
  // Held out, nm: baseline, extended, and the baseline with the truth of what was hidden added.
  double u90_before = 0, u90_after = 0, u90_known = 0;
};

PlantVerdict judged_by_truth(const PlantCase& one, const PlantRun& run,
                             const diagnosis::Diagnosis& diagnosis);
// diagnose() with few nulls; throws std::runtime_error when it refuses.
diagnosis::Diagnosis diagnosed_run(const std::string& baseline, const Dataset& data, int nulls,
                                   const std::optional<diagnosis::LeverLimits>& levers = {});
// The same with the case's baseline, and with what its cell declares of its beams.
diagnosis::Diagnosis diagnosed_case(const PlantCase& one, const Dataset& data, int nulls);
// deploy/cells/*/cell.toml of the case's robot.
CellDescription cell_of(const PlantCase& one);

}  // namespace driftwise::hidden
