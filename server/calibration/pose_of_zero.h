#pragma once
// Where the zero of a datum lies in the frame of a model's own datum: the pose p0 at which the
// model has the motor coordinates that were seen, by Newton's method on differences. Serving,
// checks and whoever else meets a datum that a model was not fitted in ask here
// (docs/decisions/0005).

#include <Eigen/Core>
#include <functional>
#include <vector>

namespace driftwise::calibration {

// What is farther than this part of an axis' fitted range is no robot that warmed, but a scale that
// was homed elsewhere.
constexpr double kFarthestZero = 0.02;

// ranges: of every axis, as fitted, the unit of the answer. left(shift): motor coordinates that
// were seen minus the model's at that shift, as many as there are axes. Answers one shift per axis;
// all 0 where a range is not positive, the outputs do not follow the axes, or p0 lies beyond
// kFarthestZero.
Eigen::VectorXd pose_of_zero(const std::vector<double>& ranges,
                             const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& left);

}  // namespace driftwise::calibration
