#include "server/core/description/cell_description.h"

#include <algorithm>

namespace driftwise {
namespace {

// A coordinate that several instruments give, each in set-ups of its own, is one coordinate.
void add_once(std::vector<Channel>& channels, const Channel& channel) {
  if (std::ranges::find(channels, channel) == channels.end()) channels.push_back(channel);
}

}  // namespace

const RobotDescription* CellDescription::find_robot(std::string_view id) const {
  for (const auto& robot : robots)
    if (robot.id == id) return &robot;
  return nullptr;
}

std::vector<AxisDescription> CellDescription::axes() const {
  std::vector<AxisDescription> out;
  for (const auto& device : devices)
    out.insert(out.end(), device.axes().begin(), device.axes().end());
  return out;
}

std::vector<Channel> CellDescription::motor_channels() const {
  std::vector<Channel> out;
  for (const auto& device : devices)
    for (const auto& axis : device.axes()) out.push_back(axis.channel);
  return out;
}

std::vector<Channel> CellDescription::length_channels() const {
  std::vector<Channel> out;
  for (const auto& device : devices)
    if (const auto* length = device.length()) add_once(out, length->channel);
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
    for (const auto& angle : device.angles()) add_once(out, angle.channel);
  return out;
}

std::optional<Channel> CellDescription::force_channel() const {
  if (!load) return std::nullopt;
  const auto* actuator = load_actuator();
  return actuator ? *actuator->force() : Channel{"force", "N"};
}

const DeviceDescription* CellDescription::load_actuator() const {
  for (const auto& device : devices)
    if (device.role() == DeviceRole::load) return &device;
  return nullptr;
}

std::vector<Channel> CellDescription::temperature_channels() const {
  std::vector<Channel> out;
  for (const auto& device : devices)
    for (const auto& probe : device.probes()) out.push_back(probe.channel);
  return out;
}

const DeviceDescription* CellDescription::find_device(const std::string& id) const {
  for (const auto& device : devices)
    if (device.id == id) return &device;
  return nullptr;
}

const AxisDescription* CellDescription::find_axis(const std::string& channel_name) const {
  for (const auto& device : devices)
    for (const auto& axis : device.axes())
      if (axis.channel.name() == channel_name) return &axis;
  return nullptr;
}

}  // namespace driftwise
