#pragma once
// Cell files that were in force, and what data rest on, as the store keeps them.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/core/cell_time.h"
#include "server/core/ids.h"

namespace driftwise {

// One start of the daemon with the cell file that it read.
struct ConfigurationStart {
  std::int64_t id = 0;
  std::string hash;
  // The cell file that it was compared with: the last one in force that puts no question (any
  // more). Empty: the first start on this database.
  std::string before_hash;
  std::string changes_json;  // server/formats/configuration_json.h
  bool asks = false;         // at least one change asks for a person
  std::string version;       // of the program
  Stamp at;
  CellTime accepted;  // utc_ns 0: nobody has answered
  std::string accepted_by, note;
  bool is_open() const { return asks && accepted.utc_ns == 0; }
};

struct UsedConfiguration {
  std::string hash;
  CellTime from;  // utc_ns 0: not known
  bool operator==(const UsedConfiguration&) const = default;
};

// What a correction does to one length of one run, worked out before it was accepted.
struct LengthChange {
  RunId run;
  std::string run_name;   // filled in by whoever lists it
  std::string channel;    // "x_mm"
  CellTime from;          // of the first row that changes; utc_ns 0: an imported run
  std::int64_t rows = 0;  // that change by 0.1 nm or more
  double largest_nm = 0, rms_nm = 0;
  bool diagnosed = false;  // a run that the diagnosis looked at
};

}  // namespace driftwise
