#pragma once
// Thermometers that lie, by [hidden]: stuck, loose, mis-scaled or swapped from an instant on.

#include <map>
#include <span>
#include <vector>

#include "drivers/simulated/plant/hidden_parameters.h"

namespace driftwise::simulated {

class HiddenFaults {
 public:
  explicit HiddenFaults(std::span<const Hidden> hidden);

  // The input whose probe is wired to this one at time_s: itself, or the other of a swapped pair.
  int connected(int input, double time_s) const;
  // What the scanner gives for a true resistance. A stuck channel repeats its first value after the
  // instant to the last digit.
  double shown_ohm(int input, double time_s, double ohm, double r0_ohm);

 private:
  std::vector<HiddenThermometer> faults_;
  std::map<int, double> stuck_ohm_;
};

}  // namespace driftwise::simulated
