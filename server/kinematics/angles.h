#pragma once
// Degrees, in which drawings and robot files are written, and the size of a deviation worth
// mention.

#include <numbers>

namespace driftwise::kinematics {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;
constexpr double rad_from_deg(double deg) { return deg * kRadPerDeg; }
constexpr double deg_from_rad(double rad) { return rad / kRadPerDeg; }

// Identification works in units of this: a manufacturing deviation of lengths, and the angle that
// moves the end of the robot by as much.
constexpr double kNaturalLength_mm = 0.1;

}  // namespace driftwise::kinematics
