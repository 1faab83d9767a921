#include "server/core/description/cell_description.h"

#include <string_view>

namespace driftwise {

bool DeviceDescription::on_loopback() const {
  if (address.starts_with("localhost:") || address.starts_with("[::1]:")) return true;
  // 127.0.0.0/8 in numbers only: 127.example.org is somebody else's machine.
  const auto host = std::string_view(address).substr(0, address.rfind(':'));
  return host.starts_with("127.") &&
         host.find_first_not_of("0123456789.") == std::string_view::npos;
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

std::vector<Channel> CellDescription::path_channels() const {
  auto out = length_channels();
  if (correction)
    for (auto& channel : out) channel.symbol += "_path";
  return out;
}

std::vector<Channel> CellDescription::angle_channels() const {
  std::vector<Channel> out;
  for (const auto& device : devices)
    for (const auto& angle : device.angles) out.push_back(angle.channel);
  return out;
}

std::optional<Channel> CellDescription::force_channel() const {
  if (!load) return std::nullopt;
  const auto* actuator = load_actuator();
  return actuator ? actuator->force : Channel{"force", "N"};
}

const DeviceDescription* CellDescription::load_actuator() const {
  for (const auto& device : devices)
    if (device.force) return &device;
  return nullptr;
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
