#pragma once
// UTC on the wire. Timestamps of requests and answers are UTC, the cell lives in cell time; the
// cell that is served maps one to the other. A process serves one cell. Any thread.

#include "server/application/ports/host.h"

namespace driftwise::rpc {

void map_times_by(const application::Host* host);           // from now on; null: cell time is UTC
void stop_mapping_times_by(const application::Host* host);  // where it is still that one
UtcTime utc_from(CellTime instant);
CellTime cell_time_from(UtcTime utc);

}  // namespace driftwise::rpc
