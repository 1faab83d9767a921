#include "server/core/cell_description.h"

namespace driftwise {

bool DeviceDescription::on_loopback() const {
  return address.starts_with("127.") || address.starts_with("localhost:") || address.starts_with("[::1]:");
}

std::vector<Channel> CellDescription::motor_channels() const {
  std::vector<Channel> out;
  for (const auto& device : devices)
    for (const auto& axis : device.axes) out.push_back(axis.channel);
  return out;
}

std::vector<Channel> CellDescription::length_channels() const {
  std::vector<Channel> out;
  for (const auto& device : devices)
    if (device.length) out.push_back(*device.length);
  return out;
}

std::vector<Channel> CellDescription::temperature_channels() const {
  std::vector<Channel> out;
  for (const auto& device : devices)
    for (const auto& probe : device.probes) out.push_back(probe.channel);
  return out;
}

const DeviceDescription* CellDescription::find_device(const std::string& id) const {
  for (const auto& device : devices)
    if (device.id == id) return &device;
  return nullptr;
}

const AxisDescription* CellDescription::find_axis(const std::string& channel_name) const {
  for (const auto& device : devices)
    for (const auto& axis : device.axes)
      if (axis.channel.name() == channel_name) return &axis;
  return nullptr;
}

}  // namespace driftwise
