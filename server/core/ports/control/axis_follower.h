#pragma once
// A second port of an instrument whose reading depends on how an axis has moved: the force of a
// motor by its current, of which dry friction hides a part.

#include "server/core/channel.h"

namespace driftwise {

class AxisFollower {
 public:
  virtual ~AxisFollower() = default;
  // Axis that it wants to know of.
  virtual const Channel& followed_axis() const = 0;
  // Its readback, each time that the controller gives one. Executor's thread.
  virtual void axis_at(double q_mm) = 0;
  // What is read back next may be a jump of the counter and no way that the axis went: it was
  // homed, halted or not asked for a while.
  virtual void axis_unknown() = 0;
};

}  // namespace driftwise
