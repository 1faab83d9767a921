#pragma once
// Gates of the readings of one attempt, of a row or of a zero. Pure.

#include <string>

#include "server/application/motion/point_decision.h"
#include "server/application/motion/sampling.h"

namespace driftwise::application {

struct Finding {
  Trouble trouble = Trouble::none;
  std::string sentence;  // empty without trouble
};

// Spread of the lengths, spread of the rotations, what a second instrument confirms, and the scale
// while the instruments were read, in this order; the first that fails. confirming: a set-up whose
// second instruments count from the datum in force; nullptr: none does.
Finding judge_sampling(const Sampling& sampling, const RunRules& rules,
                       const SetupDescription* confirming);

}  // namespace driftwise::application
