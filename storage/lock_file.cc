#include "storage/lock_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "storage/failure.h"

namespace driftwise::storage {
namespace {

// Two names of one file (a symbolic link, "./x") must meet at one lock.
std::string lock_path(const std::string& database_path) {
  std::error_code ignored;
  const auto real = std::filesystem::weakly_canonical(database_path, ignored);
  return (ignored ? database_path : real.string()) + ".lock";
}

std::string holder(int descriptor) {
  char text[64];
  const ssize_t size = pread(descriptor, text, sizeof text, 0);
  std::string pid(text, size > 0 ? static_cast<std::size_t>(size) : 0);
  pid = pid.substr(0, pid.find('\n'));
  return pid.empty() ? "another process" : "process " + pid;
}

}  // namespace

LockFile::LockFile(const std::string& database_path) {
  const std::string path = lock_path(database_path);
  descriptor_ = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor_ < 0) {
    const bool full = errno == ENOSPC || errno == EDQUOT;
    throw_failure(full ? ErrorCode::resource_exhausted : ErrorCode::not_found,
                  full ? "DISK_FULL" : "CANNOT_OPEN",
                  "database " + database_path + ": cannot create its lock file " + path + ": " +
                      std::strerror(errno) +
                      ": look at the path, and at the space and rights of the folder");
  }
  // flock belongs to this open file, not to the process: a second store in the same process is
  // refused as well.
  if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
    const std::string who = holder(descriptor_);
    close(std::exchange(descriptor_, -1));
    throw_failure(ErrorCode::failed_precondition, "DATABASE_IN_USE",
                  "database " + database_path + " is being written by " + who +
                      ": stop that daemon, or give this cell a database of its own");
  }
  // For people and for the message above; the lock itself does not depend on it.
  const std::string pid = std::to_string(getpid()) + "\n";
  if (ftruncate(descriptor_, 0) == 0) (void)!pwrite(descriptor_, pid.data(), pid.size(), 0);
}

LockFile::~LockFile() {
  if (descriptor_ >= 0)
    close(descriptor_);  // the file stays: removing it would let two processes lock two files
}

LockFile::LockFile(LockFile&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

LockFile& LockFile::operator=(LockFile&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

}  // namespace driftwise::storage
