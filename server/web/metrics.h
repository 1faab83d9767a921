#pragma once
// The cell's state as Prometheus text (exposition format 0.0.4): for those who watch many machines.

#include <string>

#include "server/application/status/cell_status.h"

namespace driftwise::web {

// One sample per channel, device and run figure; names carry units as Prometheus wants them (suffix
// _total for counters). Labels are escaped. Missing values are left out. Pure.
std::string metrics_text(const application::CellStatus& status);

}  // namespace driftwise::web
