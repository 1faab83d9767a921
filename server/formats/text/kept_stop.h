#pragma once
// A stop that no daemon was there to take. The file that `driftwise stop` leaves beside
// driftwised.json is of the cell: its daemon makes it a pending stop when it starts or answers
// again. The one that `driftwise restore` leaves beside a record is of that record alone, and of
// the next start of a daemon that has it as its database.

#include <string>
#include <string_view>

namespace driftwise::formats {

inline constexpr const char* kKeptStopFile = "driftwised.stop";

// "look.db.stop": of one record, whatever cell's folder it lies in.
inline std::string kept_stop_of_record(const std::string& database) { return database + ".stop"; }

struct KeptStop {
  std::string who;    // as the client stated it; of a record, what it was restored from and by whom
  std::string asked;  // UTC by the client's clock, ISO 8601
};

std::string write_kept_stop(const KeptStop& stop);

// Any text is a stop: what cannot be understood in it is "somebody", "an unknown instant".
KeptStop read_kept_stop(std::string_view text);

}  // namespace driftwise::formats
