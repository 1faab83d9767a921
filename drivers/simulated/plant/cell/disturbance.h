#pragma once
// Where a hidden effect may act on the plant. None is installed by default: later tests add
// backlash, cyclic errors, creep, slips, without touching the plant.
//
// The stage servo hides what happens at the scale; each place says which quantity the returned
// value is added to. A robot of several axes has the first place per motor axis, the second per
// axis of the pose and the third per interferometer: the context's index says which one is asked
// for.

#include <functional>

namespace driftwise::simulated {

enum class DisturbancePlace {
  scale_nm,           // what the scale reads, against the stage's true position
  end_effector_nm,    // the mirror against the stage: robot side
  interferometer_nm,  // what the interferometer reads: instrument side
  probe_k             // what every thermometer feels (the context names its input)
};

struct DisturbanceContext {
  double time_s = 0;        // since the epoch
  int index = 0;            // see above
  double stage_mm = 0;      // true position of that axis
  double approach = 0;      // sign of the last move, 0 before any
  double since_move_s = 0;  // since the last move's end
  int input = 0;            // probe_k only
};

// Must be a pure function of the context (and of what it remembers from earlier, increasing times).
using Disturbance = std::function<double(const DisturbanceContext&)>;

}  // namespace driftwise::simulated
