#pragma once
// What of a trajectory is ahead at a place: visits, returns to zero, and the dwells that rows
// state.

#include <cstdint>
#include <vector>

#include "server/core/description/cell_description.h"
#include "server/core/records/records.h"
#include "server/core/trajectory/trajectory.h"

namespace driftwise::application {

// Planned figure of a visit: settle, readings and a typical move. Cell seconds.
double planned_visit_s(const RunRules& rules);

struct PlanAhead {
  double visits = 0;  // returns to zero included
  double dwell_s = 0;
};

class PlanLength {
 public:
  explicit PlanLength(const Trajectory& trajectory);
  PlanAhead ahead(const Place& place) const;
  // Of one row; the last row of a line has the line's own return to zero with it.
  PlanAhead row(std::int64_t row) const;

 private:
  std::vector<double> dwell_s_;        // of this row and all after it; one more at the end
  std::vector<std::int64_t> returns_;  // to zero, by itself at the end of a line: likewise
};

}  // namespace driftwise::application
