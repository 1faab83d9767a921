#pragma once
// One [[device]] of cell.toml: what every device has; its kind reads the rest.

#include <map>
#include <set>
#include <string>

#include "server/core/description/cell_description.h"
#include "server/formats/text/toml_reader.h"

namespace driftwise::formats {

// Names that may stand once in a cell.
struct TakenNames {
  std::set<std::string> ids;
  std::map<std::string, std::string> channels;  // to the device that gives it
  std::string device;                           // id of the device that is read now
  // The file has [[setup]]: a coordinate of the pose may be given by several instruments, of which
  // each set-up names one.
  bool has_setups = false;
  std::set<std::string> robots;  // ids of several robots: they stand before motor and pose channels

  // A channel that is taken is refused at key, DUPLICATE_CHANNEL.
  void channel(TomlReader& reader, const char* key, const std::string& name);
};

// place: "device 2", for messages. The first problem stands in problem.
void read_device(TomlReader&& reader, const std::string& place, DeviceKinds kinds,
                 DeviceDescription& out, TakenNames& taken, TomlProblem& problem);

}  // namespace driftwise::formats
