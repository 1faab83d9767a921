#pragma once
// Trajectories: checked against the cell, kept for later. Executor's thread.

#include <cstdint>
#include <string>
#include <vector>

#include "server/application/ports/caller.h"
#include "server/application/trajectories/outlook.h"
#include "server/core/ports/awaitable.h"
#include "server/core/records/watch_records.h"
#include "server/core/result.h"
#include "server/core/trajectory/trajectory.h"

namespace driftwise::application {

struct TrajectoryCheck {
  Trajectory trajectory;
  std::int64_t calibration = 0, validation = 0, zeros = 0, lines = 0;
  double estimated_s = 0;             // cell seconds, from its start to its end
  Outlook outlook;                    // the same as a band
  PlanAhead plan;                     // the whole of it
  std::vector<std::string> warnings;  // problems are errors: the check fails
};

class Trajectories {
 public:
  virtual ~Trajectories() = default;

  // Worked out in the background. name: of the file, for messages. Errors: those of
  // check_trajectory_text (trajectory_check.h).
  virtual Awaitable<Result<TrajectoryCheck>> check(std::string name, std::string text) = 0;
  // Checked likewise. The same text again: the first one.
  virtual Awaitable<Result<KeptTrajectory>> keep(Caller caller, std::string name,
                                                 std::string text) = 0;
};

}  // namespace driftwise::application
