#include "server/core/devices/device_description.h"

#include <algorithm>

namespace driftwise {
namespace {

static_assert(std::variant_size_v<RoleSettings> ==
              static_cast<std::size_t>(DeviceRole::supply) + 1);
template <DeviceRole kRole>
using SettingsOf = std::variant_alternative_t<static_cast<std::size_t>(kRole), RoleSettings>;
static_assert(std::is_same_v<SettingsOf<DeviceRole::motion>, MotionSettings> &&
              std::is_same_v<SettingsOf<DeviceRole::length>, LengthSettings> &&
              std::is_same_v<SettingsOf<DeviceRole::angle>, AngleSettings> &&
              std::is_same_v<SettingsOf<DeviceRole::temperature>, TemperatureSettings> &&
              std::is_same_v<SettingsOf<DeviceRole::force>, ForceSettings> &&
              std::is_same_v<SettingsOf<DeviceRole::environment>, EnvironmentSettings> &&
              std::is_same_v<SettingsOf<DeviceRole::stabiliser>, StabiliserSettings> &&
              std::is_same_v<SettingsOf<DeviceRole::load>, LoadSettings> &&
              std::is_same_v<SettingsOf<DeviceRole::probe>, ProbeSettings> &&
              std::is_same_v<SettingsOf<DeviceRole::supply>, SupplySettings>);

template <std::size_t kIndex = 0>
RoleSettings alternative(std::size_t index) {
  if constexpr (kIndex < std::variant_size_v<RoleSettings>)
    return index == kIndex ? RoleSettings(std::in_place_index<kIndex>)
                           : alternative<kIndex + 1>(index);
  else
    return {};
}

template <class Settings, class Item>
const std::vector<Item>& list_in(const RoleSettings& settings,
                                 std::vector<Item> Settings::*const list) {
  static const std::vector<Item> none;
  const auto* found = std::get_if<Settings>(&settings);
  return found ? found->*list : none;
}

}  // namespace

RoleSettings settings_for(DeviceRole role) { return alternative(static_cast<std::size_t>(role)); }

bool DeviceDescription::on_loopback() const {
  if (address.starts_with("localhost:") || address.starts_with("[::1]:")) return true;
  // 127.0.0.0/8 in numbers only: 127.example.org is somebody else's machine.
  const auto host = std::string_view(address).substr(0, address.rfind(':'));
  return host.starts_with("127.") &&
         host.find_first_not_of("0123456789.") == std::string_view::npos;
}

const std::vector<AxisDescription>& DeviceDescription::axes() const {
  return list_in(settings, &MotionSettings::axes);
}

const std::vector<AngleDescription>& DeviceDescription::angles() const {
  return length() ? length()->angles : list_in(settings, &AngleSettings::angles);
}

const std::vector<ProbeDescription>& DeviceDescription::probes() const {
  return list_in(settings, &TemperatureSettings::probes);
}

const std::vector<QuantityDescription>& DeviceDescription::quantities() const {
  return role() == DeviceRole::force ? list_in(settings, &ForceSettings::quantities)
                                     : list_in(settings, &EnvironmentSettings::quantities);
}

const Channel* DeviceDescription::force() const {
  const auto* load = std::get_if<LoadSettings>(&settings);
  return load ? &load->force : nullptr;
}

std::string symbol_from_id(std::string_view id) {
  std::string symbol(id);
  std::ranges::replace(symbol, '-', '_');
  return symbol;
}

}  // namespace driftwise
