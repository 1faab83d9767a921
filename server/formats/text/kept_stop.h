#pragma once
// A stop that no daemon was there to take: the file that `driftwise stop` leaves beside
// driftwised.json. The next start of the daemon makes it a pending stop.

#include <string>
#include <string_view>

namespace driftwise::formats {

inline constexpr const char* kKeptStopFile = "driftwised.stop";

struct KeptStop {
  std::string who;    // as the client stated it
  std::string asked;  // UTC by the client's clock, ISO 8601
};

std::string write_kept_stop(const KeptStop& stop);

// Any text is a stop: what cannot be understood in it is "somebody", "an unknown instant".
KeptStop read_kept_stop(std::string_view text);

}  // namespace driftwise::formats
