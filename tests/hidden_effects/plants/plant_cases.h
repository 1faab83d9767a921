#pragma once
// What is hidden in the plants, and what a diagnosis should say of it.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/core/description/cell_description.h"
#include "server/core/trajectory/trajectory.h"
#include "server/diagnosis/answer/diagnosis.h"
#include "tests/hidden_effects/plants/plant_run.h"

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
  // Causes that the baseline lacks beside it, and that may be named with it: a robot that gives
  // under force does so differently in every pose.
  std::vector<std::string> also{};
};

const std::vector<PlantCase>& plant_cases();
PlantRun run_case(const PlantCase& one, std::uint64_t seed);

// What there is to be found beyond the case's baseline: the case against the same plant without
// what was put into it, same seed and baseline, the difference of what the two fits leave on the
// calibration rows; rms in nm, of the output where it is largest. Nothing: nothing was put in (the
// baseline lacks terms), or the plants did not stay in step (a group was read again in one only).
std::optional<double> left_to_find_nm(const PlantCase& one, const PlantRun& run,
                                      std::uint64_t seed);

struct PlantVerdict {
  bool exact = false;   // named, in the right place, and nothing else but what it comes with
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
