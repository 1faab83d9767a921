#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "tests/hidden_effects/foreign/random.h"

namespace driftwise::foreign {

// One stop of the robot. s is in [-1, 1] per motor. A stop that is not measured only moves the
// robot.
struct Visit {
  Eigen::VectorXd s;
  double dwell_s = 0.0;
  double pause_s = 0.0;
  // Process force, as a share 0 .. 1 of the largest.
  double force = 0.0;
  // Sensed activity (spindle, heater), 0 .. 1.
  double activity = 0.0;
  int line = 0;
  int run = 1;
  int datum = 1;
  bool zero = false;
  bool measured = true;
};

// A measuring plan: stops in order and the highest geometry that its places determine.
struct Plan {
  std::string kind;
  std::vector<Visit> visits;
  int degree = 3;
  double askew_rad = 0.0;
};

// Kinds that are open, and those kept for a count on plans that were never run before.
const std::vector<std::string>& open_plans();
const std::vector<std::string>& reserved_plans();

// Highest degree of geometry that a plan of this kind determines.
int plan_degree(const std::string& kind);

// Plan of a kind for a robot of so many axes, with about `rows` measured stops.
Plan make_plan(const std::string& kind, int axes, int rows, double zero, Random& random);

}  // namespace driftwise::foreign
