#pragma once
// What a trajectory would give if it were run: the simulation forward, row by row.
//
// Each point is moved to, waited for, read: its time follows from distance, velocity and dwell, its
// motor coordinates are the targets, its pose is what the model run forward says the instruments
// should read, and what nobody moves (temperatures, air) stays as it was at the start. Effects with
// memory then see the same history as they will on the real rows.

#include <string>
#include <utility>
#include <vector>

#include "server/calibration/model/model.h"
#include "server/core/data/dataset.h"
#include "server/core/result.h"
#include "server/core/trajectory/trajectory.h"

namespace driftwise::simulation {

struct MotionTimes {
  double velocity_mm_s = 5;          // of a move
  double velocity_arcsec_s = 36000;  // of a turn: ten degrees a second
  double settle_s = 1;               // after it, before what the point asks for
  double reading_s = 2;              // of one point
  double load_s = 30;                // of a change of the force
};

// Seconds from the start to the middle of each point's readings; dwell_s: from the end of its move.
struct PointTimes {
  std::vector<double> time_s, dwell_s;
  double total_s = 0;
};
// All axes move at once, from 0.
PointTimes point_times(const Trajectory& trajectory, const MotionTimes& times);

// conditions: symbol and value of every channel that no point moves; the force where points say
// none. model: motor coordinates from poses; the trajectory's coordinates are motor coordinates.
// Times start at start_s. Errors: those of ForwardModel.
Result<Dataset> planned_rows(const calibration::Model& model, const Trajectory& trajectory,
                             const std::vector<std::pair<Channel, double>>& conditions,
                             const MotionTimes& times, double start_s);

}  // namespace driftwise::simulation
