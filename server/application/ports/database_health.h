#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/core/cell_time.h"

namespace driftwise::application {

// Result of the checks of the stored pages.
struct DatabaseHealth {
  CellTime last_clean;                          // utc_ns 0: never checked whole
  std::int64_t tables = 0, tables_checked = 0;  // of the present pass
  std::vector<std::string> troubles;            // a sentence each
};

}  // namespace driftwise::application
