#pragma once
// Points measured since an instant rest on a cell beyond a limit ([[hold]]).

#include <string>

#include "server/core/cell_time.h"

namespace driftwise::application {

struct HoldMark {
  CellTime since;
  std::string reason;
};

}  // namespace driftwise::application
