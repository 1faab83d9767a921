#pragma once
// Thinning of raw readings of the environment: what is asked for and what was done.

#include <cstdint>
#include <string>
#include <string_view>

#include "server/core/cell_time.h"
#include "server/core/records/audit_records.h"

namespace driftwise {

// How the values of an interval become one: "mean", "min", "max".
inline bool is_reducer(std::string_view name) {
  return name == "mean" || name == "min" || name == "max";
}

struct ThinningOrder {
  CellTime before;            // readings that began before this, down to a whole interval
  std::int64_t every_ns = 0;  // length of an interval
  std::string reducer;
  Stamp at;
  Identity by;
  std::int64_t after_id = 0;  // readings up to this one were looked at; 0: none
};

struct ThinningStep {
  std::int64_t readings = 0;   // removed
  std::int64_t intervals = 0;  // of one device each, stored in their place
  std::int64_t looked_id = 0;  // readings up to this one were looked at
  bool more = false;           // ask again with after_id = looked_id
};

}  // namespace driftwise
