#pragma once
// The switches of all devices and of the wire, from the plant file's [emulator.<kind>],
// [emulator.<device id>] and [wire] tables and from --set emulator.<kind or id>.<switch>=value,
// --set wire.<switch>=value. The more special wins: id over kind, command line over file.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "drivers/simulated/emulators/all_emulators.h"
#include "drivers/simulated/emulators/cell/cell_outline.h"
#include "drivers/simulated/emulators/switches.h"
#include "drivers/simulated/emulators/wire.h"

namespace driftwise::simulated {

const std::vector<SwitchDescription>& wire_switches();

class EmulatorOptions {
 public:
  // Takes the settings that begin with "emulator." or "wire." out of `settings`; the others are the
  // plant's. Throws SetupError: file or setting unreadable, a section that is neither kind nor
  // device, a switch that is not there.
  EmulatorOptions(const std::filesystem::path& plant_file, std::vector<std::string>& settings,
                  const std::vector<DeviceOutline>& devices);

  const Switches& of(const std::string& device_id) const { return by_device_.at(device_id); }
  WireOptions wire(std::uint64_t seed) const;

 private:
  void set(const std::string& section, const std::string& name, const std::string& value,
           const std::string& place, bool by_id);
  std::vector<DeviceOutline> devices_;
  std::map<std::string, Switches> by_device_;
  Switches wire_;
};

}  // namespace driftwise::simulated
