#pragma once
// The parameters of a mechanism: what identification may change.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "server/core/result.h"

namespace driftwise::kinematics {

struct Parameter {
  std::string name;  // as the robot file writes it, with its unit: "link2.alpha_deg"
  double nominal = 0;
  double natural = 1;  // a deviation that is worth mention, same unit: the scale identification
                       // works in
  // Of parameters that the data cannot tell apart the one with the higher rank is held.
  int rank = 0;
  bool placement = false;  // says where the robot stands or reads zero, not how it was made
  bool held = false;       // the description says so
};

using Parameters = std::vector<Parameter>;

Eigen::VectorXd nominal_values(const Parameters& parameters);

// Marks what the patterns name; '*' stands for any text. Errors: invalid_argument
// UNKNOWN_PARAMETER (a pattern that names nothing, with the names there are).
Result<void> hold(Parameters& parameters, const std::vector<std::string>& patterns);

}  // namespace driftwise::kinematics
