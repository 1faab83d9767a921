#pragma once
// The cell's state as Prometheus text (exposition format 0.0.4): for those who watch many machines.

#include <string>

#include "server/application/status/cell_status.h"

namespace driftwise::web {

// One sample per channel, device and run figure, and the process' own memory, processor time and
// descriptors. Names follow Prometheus' conventions: a family has one base unit and is named by it
// (driftwise_position_meters{channel="x"}), counters end in _total. Labels are escaped. Missing
// values, and channels in a unit that is none of a physical quantity, are left out. Any thread.
std::string metrics_text(const application::CellStatus& status);

}  // namespace driftwise::web
