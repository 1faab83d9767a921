#pragma once
// Kinds of a [[device]] of kind keithley-2701: thermometers, or sensors whose output is a
// voltage. Keys: docs/devices/analogue.md.

#include <vector>

#include "server/core/devices/device_description.h"
#include "server/core/devices/settings_reader.h"

namespace driftwise::keithley {

// By the key `measures`; the device gets the role that goes with it. Refused: BAD_CHANNEL,
// BAD_LIMITS, BAD_UNIT, BAD_VALUE, DUPLICATE_CHANNEL, MISSING_KEY.
void read_settings(SettingsReader& reader, DeviceDescription& device);

std::vector<Channel> channels_of(const DeviceDescription& device);

}  // namespace driftwise::keithley
