#pragma once
#include <string>
#include <vector>

#include "clients/cli/core/session.h"

namespace driftwise::cli {

struct ArmTargetArguments {
  std::string kinematics;         // robot file or cell.toml of a serial arm
  std::vector<std::string> pose;  // "x=800", "rx_deg=180", "t04_degC=23.1"
  std::vector<std::string> near;  // "q1_deg=20"; a joint that is missing: 0
};

// target --kinematics robot.toml x=... --near q1=...: joint angles by the robot file, with the
// errors of its joints in. Needs no daemon.
ExitCode arm_target(const Session& session, const ArmTargetArguments& a);

}  // namespace driftwise::cli
