#pragma once
// A drawing with other numbers: what an identification found, as a description that can be written
// to a robot file and be the nominal robot of the next.

#include <Eigen/Core>

#include "server/kinematics/mechanism.h"

namespace driftwise::kinematics {

// The mechanism's description with these values of its parameters (one per parameter, in its unit).
// What it holds stays held; parameters that a description has no key for keep what it says.
KinematicsDescription with_values(const Mechanism& mechanism, const Eigen::VectorXd& values);

}  // namespace driftwise::kinematics
