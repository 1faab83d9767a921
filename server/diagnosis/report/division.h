#pragma once
// Division of a correction between the robot and its instruments, which are fitted side by side: a
// robot that warms moves, and an instrument that warms only reads as if it had. What belongs to
// whom matters, for the robot's part is served and the instrument's is taken off the readings.
//
// The instruments' part: findings that apply to the correction, and baseline terms of thermometers
// that the cell file places on the instrument. The robot's part: the other baseline terms that read
// a temperature of the structure, and findings that apply to the robot. Both are counted from the
// first row.

#include <string>
#include <vector>

#include "server/diagnosis/catalogue/cause.h"
#include "server/diagnosis/growth/extension.h"
#include "server/diagnosis/rows/problem.h"

namespace driftwise::diagnosis {

struct Division {
  std::string output, unit;                  // summary unit
  double robot_rms = 0, instrument_rms = 0;  // over the rows of the search
  // U90 of the instruments' part, under the priors: what the data leave to either side.
  double u90 = 0;
  // The same if the points were measured once more from another temperature: the structure begins
  // 1 K away from where it began and comes back with a time constant of 2 h, or a third of the run
  // where that is shorter; air and instruments are as they were. By the covariance of the joint
  // fit, before anything is measured.
  double u90_with_another_start = 0;
  std::vector<std::string> robot, instruments;  // names of what is on each side
};

// One per output that has both sides; empty: nothing to divide, or no time to count a start from.
std::vector<Division> divisions_of(const Problem& problem, const std::vector<Cause>& causes,
                                   const Extension& extension);

// Is the division known to a quarter of the smaller side, or to a tenth of the larger one?
bool is_divided(const Division& division);

// "q1: 120 nm rms of the correction rest on the robot (t03), 35 nm on instruments
// (refractive_index); they are told apart to 8 nm". Where they are not: the run that would.
std::string sentence(const Division& division);

// One sentence for each named thermal cause whose thermometer the data place on an instrument: the
// catalogue knows such a cause of the robot only.
std::vector<std::string> thermal_causes_of_instruments(const Problem& problem,
                                                       const std::vector<Cause>& causes,
                                                       const Extension& extension);

}  // namespace driftwise::diagnosis
