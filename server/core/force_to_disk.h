#pragma once
// A file, or the names in a folder, brought from the kernel's memory to the disk, so that they are
// there after a loss of power.

#include <fcntl.h>
#include <unistd.h>

namespace driftwise {

// False: the disk does not say that it has it.
inline bool force_to_disk(const char* path) {
  const int file = ::open(path, O_RDONLY | O_CLOEXEC);
  if (file < 0) return false;
  const bool done = ::fsync(file) == 0;
  ::close(file);
  return done;
}

}  // namespace driftwise
