#pragma once
// Designs that tell causes apart, as trajectories of motor coordinates: what each of them is good
// for is NUMERICS.md section 3, "Look-alikes, and what separates them".

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/core/trajectory/trajectory.h"

namespace driftwise::diagnosis {

struct PlanLimits {
  std::vector<Channel> coordinates;  // "q1 mm", "q2 arcsec"
  std::vector<double> min, max;      // one per coordinate, in its unit
  std::vector<double> forces_n;      // that may be hung, ascending; fewer than two: none is
  std::optional<double>
      period;  // in the coordinates' unit; under suspicion: steps are laid across it
};

struct CandidatePlan {
  std::string what;  // "dwells of 1 s and 100 s, approaches from both sides"
  Trajectory trajectory;
};

// Every design that the limits allow, with about so many points. Deterministic.
std::vector<CandidatePlan> candidate_plans(const PlanLimits& limits, std::size_t points);

}  // namespace driftwise::diagnosis
