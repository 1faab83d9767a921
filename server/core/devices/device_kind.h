#pragma once
// A kind of device as its driver declares it, once: drivers/<device>/device.cc. The list of all is
// drivers/all_devices.cc.

#include <span>
#include <string_view>
#include <vector>

#include "server/core/devices/device_description.h"
#include "server/core/devices/settings_reader.h"
#include "server/core/result.h"

namespace driftwise {

// Both in server/core/ports/made_device.h.
struct DeviceContext;
struct MadeDevice;

// An option that chooses one of the outputs at a device's address, and its value when it is absent.
struct OutputOption {
  std::string_view name, preset;
};

struct DeviceKind {
  std::string_view id;  // as [[device]] kind names it: "pi-gcs"
  DeviceRole role;
  // Reads what belongs to the kind into description.settings, which hold the role's defaults.
  void (*read_settings)(SettingsReader& reader, DeviceDescription& device);
  // Every channel that a reading of a device with these settings and options can hold: the one list
  // for duplicates, holds, limits, alarms and datasets.
  std::vector<Channel> (*channels)(const DeviceDescription& device);
  // The driver behind the role's port. Connects in prepare() or the first call, not here.
  // Errors: invalid_argument naming the option or the key.
  Result<MadeDevice> (*make)(const DeviceDescription& device, const DeviceContext& context);
  std::span<const OutputOption> output_options = {};
  // Takes turns with devices of other kinds behind one serial server (host:port).
  bool shares_line = false;
};

// In the order in which messages name them.
using DeviceKinds = std::span<const DeviceKind* const>;

inline const DeviceKind* find_kind(DeviceKinds kinds, std::string_view id) {
  for (const auto* kind : kinds)
    if (kind->id == id) return kind;
  return nullptr;
}

}  // namespace driftwise
