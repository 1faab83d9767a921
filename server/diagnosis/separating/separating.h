#pragma once
// The measurement that would tell an indistinguishable set apart: the shortest of the designs whose
// power, predicted by simulating every hypothesis forward, is enough; or why there is none.

#include <optional>
#include <string>

#include "server/calibration/fit.h"
#include "server/core/data/dataset.h"
#include "server/core/result.h"
#include "server/core/trajectory/trajectory.h"
#include "server/diagnosis/answer/diagnosis.h"
#include "server/diagnosis/separating/separating_plans.h"
#include "server/simulation/planned_rows.h"

namespace driftwise::diagnosis {

struct SeparatingLimits {
  // Where the robot may go and what may be hung; empty coordinates: where the data have been, and
  // the forces that they have seen.
  PlanLimits plan;
  simulation::MotionTimes times;
  double budget_s = 4 * 3600;
  double min_power = 0.95;
  int simulations = 200;  // of the noise, per hypothesis and plan
  std::uint64_t seed = 1;
};

struct SeparatingPlan {
  std::string why;  // what it separates and how; or why none exists
  std::optional<double> predicted_power;
  std::optional<Trajectory> trajectory;
  double estimated_s = 0;
};

// Limits as far as the data show them: ranges, forces, and the time that a point takes.
SeparatingLimits limits_from(const Dataset& dataset);

// Nothing where no finding has rivals. baseline: the one that was diagnosed. The plan is for the
// first finding whose rivals some design tells apart, wholly or into classes (sensors of one
// temperature stay together while the room does not change): the design that leaves the fewest
// together, of those the shortest. It is judged by itself, without the old rows, with the
// baseline's coefficients free. Errors: those of open_hypotheses() and of the forward model.
Result<std::optional<SeparatingPlan>> separating_plan(const Dataset& dataset,
                                                      const calibration::Candidates& baseline,
                                                      const Diagnosis& diagnosis,
                                                      const SeparatingLimits& limits);

}  // namespace driftwise::diagnosis
