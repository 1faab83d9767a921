#pragma once
// Settings that every kind of a role has: what DeviceKind::read_settings calls. Each fills the
// description's settings; keys, units and defaults are in docs/cell-file.md.

#include <vector>

#include "server/core/devices/device_description.h"
#include "server/core/devices/settings_reader.h"

namespace driftwise {

// [[device.axis]]: motor coordinates in mm, limits around zero.
void read_motion_settings(SettingsReader& reader, DeviceDescription& device);
// length, u_length_nm, u_drift_nm_per_h, u_drift_nm_per_k, drift_channel.
void read_length_settings(SettingsReader& reader, DeviceDescription& device);
// [[device.angle]]: rotations in arcsec, each axis of the instrument once.
void read_angle_settings(SettingsReader& reader, DeviceDescription& device);
// [[device.probe]]: temperatures in degC, each input once.
void read_temperature_settings(SettingsReader& reader, DeviceDescription& device);
// No key of its own: channels are named after the id.
void read_stabiliser_settings(SettingsReader& reader, DeviceDescription& device);
// No key of its own: the kind names its channels after the id.
void read_supply_settings(SettingsReader& reader, DeviceDescription& device);
// channel = "force_N".
void read_load_settings(SettingsReader& reader, DeviceDescription& device);

// Channels that the role's settings name; of a stabiliser <id>_degC, <id>_set_degC, <id>_power_pct.
std::vector<Channel> channels_of_settings(const DeviceDescription& device);

}  // namespace driftwise
