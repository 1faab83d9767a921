#pragma once
// What becomes of a diagnosis that is accepted, judged by the plant's truth: the extension is made
// by the code that the daemon accepts with, its model is served, and asked for the poses where the
// end-effector really was it should answer what the scales read.

#include <string>
#include <vector>

#include "tests/hidden_effects/plants/plant_cases.h"

namespace driftwise::hidden {

// Served target minus what the scale read at the truth of each validation row, nm.
struct ServedOutput {
  std::string output;  // "q1"
  // The baseline fitted to the data as they were measured; the accepted extension; a plant with the
  // same seed that hides nothing.
  std::vector<double> before_nm, after_nm, nothing_hidden_nm;
};

double u90_at_truth(const std::vector<double>& errors);  // 1.645 x rms
struct AcceptedOnPlant {
  std::string named;    // "cyclic_error x + ..."; "" for nothing
  std::string refused;  // why nothing came of it: nothing found, not servable; "" when it serves
  std::string formula;  // of the model that serves
  std::vector<std::string> shifted;  // lengths that are corrected
  std::vector<ServedOutput> outputs;
};

// Those of plant_cases() whose cause is an instrument's error: what applies to the correction
// stage.
std::vector<PlantCase> instrument_cases();

// Every finding is accepted, as an operator would who believes them all. Throws std::runtime_error
// where the baseline itself cannot be fitted and served.
AcceptedOnPlant accepted_on_plant(const PlantCase& one, std::uint64_t seed, int nulls);

// S90 after over S90 before of one output, geometric mean over plants (two or more), and the lower
// end of its 90 % interval by Student's t: above 1, it is harmed. A plant is one draw: its own
// constant errors may hide a disturbance or add to it, so its rows are no further evidence.
struct HarmRatio {
  double mean = 1, low = 0;
};
HarmRatio harm_of(const std::vector<AcceptedOnPlant>& plants, std::size_t output);

}  // namespace driftwise::hidden
