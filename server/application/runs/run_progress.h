#pragma once
// Progress of a run: one message of a watch.

#include <cstdint>
#include <string>

#include "server/application/trajectories/outlook.h"
#include "server/core/cell_time.h"
#include "server/core/records/records.h"

namespace driftwise::application {

struct RunProgress {
  RunRecord run;
  std::string phase;  // "checking", "homing", "moving", "settling", "reading", "waiting for the
                      // stabiliser", ...
  std::int64_t row = 0, line = 0;
  double last_spread_nm = kMissing, last_closure_nm = kMissing;
  CellTime estimated_end;     // utc_ns 0: unknown
  double remaining_s = 0;     // of measuring, cell time: what a run that waits has still ahead
  Outlook outlook;            // the same as a band
  std::int64_t sequence = 0;  // grows with every change
  bool unstored = false;      // the disk takes nothing: the record has another state
};

}  // namespace driftwise::application
