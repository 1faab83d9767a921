#pragma once

#include <sys/mman.h>

#include <new>
#include <stdexcept>

#include "tests/support/small_world.h"

namespace driftwise::tests {

// The world lies in memory that both processes share: it does not end with the daemon.
class SharedWorld {
 public:
  SharedWorld() {
    void* place = ::mmap(nullptr, sizeof(SmallWorld), PROT_READ | PROT_WRITE,
                         MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (place == MAP_FAILED) throw std::runtime_error("mmap");
    world_ = new (place) SmallWorld;
  }
  ~SharedWorld() { ::munmap(world_, sizeof(SmallWorld)); }
  SmallWorld& operator*() { return *world_; }
  SmallWorld* operator->() { return world_; }

 private:
  SmallWorld* world_;
};

}  // namespace driftwise::tests
