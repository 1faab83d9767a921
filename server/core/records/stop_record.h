#pragma once
// A stop that a person asked for, per motion controller.

#include <cstdint>
#include <string>

#include "server/core/cell_time.h"

namespace driftwise {

struct StopId {
  std::int64_t value = 0;
  auto operator<=>(const StopId&) const = default;
};

// Pending from `asked` until `confirmed`: an instant at which the controller itself had reported no
// motion in two successive answers.
struct StopRecord {
  StopId id;
  std::string controller;    // device id in the cell file
  std::string who, from;     // as in EventRecord; of the first request
  std::string cause;         // a phrase: "stopped by ada"; of the last request
  Stamp asked;               // of the first request
  std::int64_t presses = 1;  // requests while it was pending
  CellTime confirmed;        // utc_ns 0: pending
  // Of the last request: the hold that a run has by it. In the run's row, not in the stop's: read
  // back they are those of the first.
  std::string held_by{};
  CellTime held_at{};
};

}  // namespace driftwise
