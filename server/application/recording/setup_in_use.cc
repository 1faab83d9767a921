#include "server/application/recording/setup_in_use.h"

#include <algorithm>

namespace driftwise::application {

bool SetupInUse::leaves_out(const DeviceDescription& device) const {
  return setup_ && measures_pose(device.role()) &&
         std::ranges::find(setup_->coordinates, device.id, &SetupCoordinate::device) ==
             setup_->coordinates.end() &&
         std::ranges::find(setup_->confirmations, device.id, &SetupConfirmation::device) ==
             setup_->confirmations.end();
}

bool SetupInUse::may_lose(const std::string& device) const {
  if (!setup_) return false;
  const auto is_confirmed_here = [&](const SetupCoordinate& coordinate) {
    return std::ranges::any_of(setup_->confirmations, [&](const SetupConfirmation& one) {
      return one.device == device && one.channel == coordinate.channel;
    });
  };
  return std::ranges::all_of(setup_->coordinates, [&](const SetupCoordinate& coordinate) {
    return coordinate.may_be_missing() ||
           (coordinate.device != device && !is_confirmed_here(coordinate));
  });
}

Reading SetupInUse::under_confirming_names(Reading reading) const {
  if (!setup_) return reading;
  for (const auto& one : setup_->confirmations)
    for (auto& value : reading.values)
      if (one.device == reading.device && value.channel == one.channel.name())
        value.channel = one.confirmed().name();
  return reading;
}

}  // namespace driftwise::application
