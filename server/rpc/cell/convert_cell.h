#pragma once
// The cell's status, devices, lease and events: domain -> proto.

#include "driftwise/v1/cell_service.pb.h"
#include "server/application/holds/hold_status.h"
#include "server/application/status/cell_status.h"

namespace driftwise::rpc {

v1::Device device_from(const application::DeviceStatus& device);
v1::Lease lease_from(const application::Lease& lease);
v1::Event event_from(const EventRecord& event);
v1::PendingStop pending_stop_from(const StopRecord& stop);
v1::Hold hold_from(const application::HoldStatus& hold);
v1::GetStatusResponse status_from(const application::CellStatus& status);

}  // namespace driftwise::rpc
