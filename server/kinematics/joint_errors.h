#pragma once
// Errors of an arm's joints beyond its drawing: sag under gravity, play, gears, drift.
//
// The errors come from the joint angles as read back and from temperatures. Gravity's torque is
// that of the nominal arm: its deviations change the torque by parts in a thousand.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "server/core/description/kinematics_description.h"

namespace driftwise::kinematics {

// Any link or the tool has a mass.
bool has_masses(const KinematicsDescription& arm);
bool has_joint_errors(const KinematicsDescription& arm);

// Gravity's torque about each joint's axis, positive where it turns the joint forwards. With
// masses: N m. Without: m, the lever of the centre of all that the joint carries, its mass spread
// evenly along the drawing's lengths. angles_rad: one per joint.
Eigen::VectorXd gravity_torques(const KinematicsDescription& arm,
                                std::span<const double> angles_rad);

// Flank of the play that gravity chooses: 1 or -1. It passes through 0 within kFloating of no
// torque, where friction holds the joint between the flanks.
constexpr double kFloating_m = 0.01, kFloating_newton_m = 0.5;
double play_side(double torque, bool masses);

// Temperatures that the errors read, each once, in the order of the joints.
std::vector<Channel> drift_channels(const KinematicsDescription& arm);

// Turn of each joint by its errors, rad. temperatures: one per drift channel, in its unit.
Eigen::VectorXd joint_turns_rad(const KinematicsDescription& arm,
                                std::span<const double> angles_rad,
                                std::span<const double> temperatures);

}  // namespace driftwise::kinematics
