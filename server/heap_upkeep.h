#pragma once
// Free memory of the heap, given back to the system. A run's end reads whole runs and lets go of
// them again; what lies between blocks that stay is kept by the C library, a little more each time.

#include <functional>
#include <thread>

#include "server/core/cell_time.h"

namespace driftwise {

// Every ten minutes of cell time, on a thread of its own, until it is destroyed.
class HeapUpkeep {
 public:
  // now: any thread; outlives this.
  explicit HeapUpkeep(std::function<CellTime()> now);

 private:
  std::jthread thread_;
};

}  // namespace driftwise
