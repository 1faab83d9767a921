#pragma once
// Disk without room, under every database of this process: a write that would make a file larger is
// answered as a full disk answers it, one into room that a file has succeeds.

#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>

namespace driftwise::storage {

class DiskWithoutRoom {
 public:
  DiskWithoutRoom() {
    system_write_ = reinterpret_cast<Write>(vfs()->xGetSystemCall(vfs(), kCall));
    if (system_write_ == nullptr) throw std::runtime_error("SQLite has no call pwrite64");
    replace(reinterpret_cast<sqlite3_syscall_ptr>(&DiskWithoutRoom::write));
  }
  ~DiskWithoutRoom() { replace(nullptr); }
  DiskWithoutRoom(const DiskWithoutRoom&) = delete;
  DiskWithoutRoom& operator=(const DiskWithoutRoom&) = delete;

 private:
  using Write = ssize_t (*)(int, const void*, size_t, off_t);
  static constexpr const char* kCall = "pwrite64";
  static sqlite3_vfs* vfs() { return sqlite3_vfs_find(nullptr); }
  static void replace(sqlite3_syscall_ptr call) { vfs()->xSetSystemCall(vfs(), kCall, call); }
  static ssize_t write(int file, const void* bytes, size_t count, off_t at) {
    struct stat found {};
    if (::fstat(file, &found) == 0 && at + static_cast<off_t>(count) > found.st_size) {
      errno = ENOSPC;
      return -1;
    }
    return system_write_(file, bytes, count, at);
  }
  inline static Write system_write_ = nullptr;
};

}  // namespace driftwise::storage
