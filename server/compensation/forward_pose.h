#pragma once
// The pose that the robot has: the served model turned round. A snapshot gives motor coordinates of
// a pose, q = c'b(pose); this solves it for the pose by Newton's method, from the middle of the
// fitted domain.
//
// Pure, any thread; allocates. Cost: a few targets.

#include <vector>

#include "server/compensation/target.h"
#include "server/core/result.h"

namespace driftwise::compensation {

struct ForwardRequest {
  std::vector<double> q_mm;  // one per Snapshot::outputs, in their order
  // What is known beside them: the force, and pose coordinates that the motors do not decide. All
  // other coordinates that the model depends on are solved for. now: as in a TargetRequest.
  TargetRequest stated;
};

struct ForwardPose {
  struct Coordinate {
    Variable variable = Variable::x;
    double value = 0;  // mm or arcsec
    // Standard uncertainty in the same unit: that of the motor coordinates through the inverse of
    // the model's slopes. A declared error of an instrument or a thermometer acts on all of them
    // with its signs; fit, residual and scale are independent from motor to motor.
    double u = 0;
  };
  std::vector<Coordinate> coordinates;  // solved for, in order of Variable
  Target target;                        // at that pose: its flags; q_mm equals the request's
};

// Errors: those of refusal_error; invalid_argument NOT_SQUARE (more or fewer coordinates to solve
// for than motor coordinates: says which to state), MISSING_VALUE (not one q per output),
// NOT_FINITE; failed_precondition NO_CONVERGENCE (no pose within twice the domain gives these motor
// coordinates, or the slopes are singular there).
Result<ForwardPose> forward_pose(const Snapshot& snapshot, const ForwardRequest& request);

}  // namespace driftwise::compensation
