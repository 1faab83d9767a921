#pragma once
// Joint targets: snapshots of the plan that serves.

#include "server/plans/joint_snapshot.h"

namespace driftwise::application {

class JointTargets {
 public:
  virtual ~JointTargets() = default;
  // Any thread; readers take no lock.
  virtual const plans::JointBoard& board() const = 0;
};

}  // namespace driftwise::application
