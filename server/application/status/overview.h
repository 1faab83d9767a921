#pragma once
// The cell as a whole: its description and its state now. Executor's thread.

#include "server/application/status/cell_status.h"
#include "server/core/description/cell_description.h"

namespace driftwise::application {

class Overview {
 public:
  virtual ~Overview() = default;
  virtual CellStatus status() const = 0;
  virtual const CellDescription& description() const = 0;  // any thread
};

}  // namespace driftwise::application
