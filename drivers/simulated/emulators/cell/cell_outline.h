#pragma once
// What the simulated cell must know of a cell file: which devices there are and what time it is
// there. Own reader: the plant's side shares no code with the daemon, which checks the file in
// full.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/simulated/emulators/switches.h"
#include "drivers/simulated/plant/plant.h"

namespace driftwise::simulated {

struct DeviceOutline {
  std::string id, kind, address;
};

struct CellOutline {
  std::filesystem::path file;
  std::string text;
  std::vector<DeviceOutline> devices;
  std::optional<TimeNs> epoch;
  double speed = 1;
  std::string clock_file;  // empty: none
};

// Throws SetupError with file, line and field.
CellOutline read_cell_outline(const std::filesystem::path& file);

// Changes to a cell file that keep everything else as it stands, comments included.
struct CellChanges {
  std::vector<std::pair<std::string, std::string>> addresses;  // device id, new address
  std::string epoch, clock_file;                               // texts; speed as a number
  double speed = 1;
};
// Sets those and lets listen and target_line pick free ports ("127.0.0.1:0"). Throws SetupError.
std::string instance_text(const CellOutline& outline, const CellChanges& changes);

TimeNs parse_utc(const std::string& text);  // "2026-11-21T08:00:00.5Z"; throws SetupError
std::string utc_text(TimeNs time);

}  // namespace driftwise::simulated
