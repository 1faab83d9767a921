#pragma once
// Points measured in a stretch of time rest on a cell beyond a limit ([[hold]]).

#include <optional>
#include <string>

#include "server/core/cell_time.h"

namespace driftwise::application {

struct HoldMark {
  CellTime since;
  std::optional<CellTime> until;  // none: it still is
  std::string reason;
};

}  // namespace driftwise::application
