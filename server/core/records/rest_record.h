#pragma once
// A cell left at rest, as the store keeps it.

#include <cstdint>
#include <string>

#include "server/core/cell_time.h"

namespace driftwise {

struct RestRecord {
  std::int64_t id = 0;
  CellTime begin, end;  // end.utc_ns 0: under way
  std::string begun_by, end_reason;
  // Limits of drift, over windows.
  double length_nm_per_h = 0, temperature_k_per_h = 0, window_s = 0;
  bool operator==(const RestRecord&) const = default;
};

}  // namespace driftwise
