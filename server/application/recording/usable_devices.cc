#include "server/application/recording/usable_devices.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/core/reasons.h"

namespace driftwise::application {
namespace {

std::vector<const DeviceDescription*> with_role(const CellDescription& cell, DeviceRole role) {
  std::vector<const DeviceDescription*> found;
  for (const auto& device : cell.devices)
    if (device.role() == role) found.push_back(&device);
  return found;
}

// "kind \"pi-gcs\""
std::string kinds_with(const CellDescription& cell, DeviceRole role) {
  std::string text;
  for (const auto* kind : cell.kinds)
    if (kind->role == role)
      text += fmt::format("{}\"{}\"", text.empty() ? "kind " : " or ", kind->id);
  return text;
}

}  // namespace

Result<void> check_usable(const CellDescription& cell) {
  const auto controllers = with_role(cell, DeviceRole::motion);
  if (controllers.empty())
    return fail(ErrorCode::invalid_argument, reasons::kNoController,
                fmt::format("{}: the cell file names no motion controller ({})", cell.name,
                            kinds_with(cell, DeviceRole::motion)));
  for (const auto* controller : controllers)
    if (controllers.size() > 1 &&
        std::ranges::find(cell.robots, controller->id, &RobotDescription::controller) ==
            cell.robots.end())
      return fail(ErrorCode::invalid_argument, reasons::kTwoControllers,
                  fmt::format("device '{}': this file names {} motion controllers and no [[robot]] "
                              "that this one moves: name each robot with its controller",
                              controller->id, controllers.size()));
  if (const auto loads = with_role(cell, DeviceRole::load); loads.size() > 1)
    return fail(
        ErrorCode::invalid_argument, reasons::kTwoLoads,
        fmt::format("device '{}': a cell has one load actuator, this file names a second one",
                    loads[1]->id));
  for (const auto* probe : with_role(cell, DeviceRole::probe))
    return fail(
        ErrorCode::invalid_argument, reasons::kRoleNotUsed,
        fmt::format("device '{}': nothing in this version reads a touch probe: leave it out "
                    "of the cell file",
                    probe->id));
  return {};
}

}  // namespace driftwise::application
