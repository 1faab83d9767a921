#pragma once
// A SQLite file system layer for tests: the default one with a disk that forgets what was not
// synced, and that can fill up or fail.
//
//   UnsyncedVfs disk("cut");                                   // registered under this name while
//   it lives auto store = open_sqlite_store(path, false, {.vfs = "cut"});
//   disk.cut_power_at(disk.changes() + 17);                    // the 17th change from now does not
//   get through
//   ... until calls fail ...
//   disk.write_survivors(other_folder, {.survivors = Survivors::random, .seed = 7});
//
// Files live in the real folder, so locks and shared memory are the real ones and read-only stores
// in other threads work as under the daemon; a SimulatedDisk records beside it what has been
// synced. Syncs are not passed on (a test disk need not wait). The folder is synced when the
// default layer would: with the first sync of a log or journal that the connection may create, and
// with a removal that asks for it. The -shm file is no file of the disk: after a power cut it is
// gone, or, worse, left with garbage.
//
// Changes are what a disk is asked to do: write, truncate, sync, create, remove. They are counted
// from 1. Thread: any; SQLite calls it on its connections' threads.

#include <sqlite3.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "tests/faults/simulated_disk.h"

namespace driftwise::faults {

class UnsyncedVfs {
 public:
  explicit UnsyncedVfs(std::string name);
  ~UnsyncedVfs();  // after every connection is closed
  UnsyncedVfs(const UnsyncedVfs&) = delete;
  UnsyncedVfs& operator=(const UnsyncedVfs&) = delete;

  const std::string& name() const { return name_; }
  std::int64_t changes() const;

  // The power fails during this change: it is recorded as unsynced (a sync: not done), and from
  // then on every call fails with an I/O error.
  void cut_power_at(std::int64_t change);
  bool power_is_cut() const;

  // From this change on, changes that need room (write, truncate, create) or every sync answer with
  // this code, SQLITE_FULL or SQLITE_IOERR_*, and leave the file as it is, until heal().
  // system_errno: what the failed call of the system leaves in errno; 0: nothing.
  void fail_writes_from(std::int64_t change, int code, int system_errno = 0);
  void fail_syncs_from(std::int64_t change, int code, int system_errno = 0);
  void heal();

  // Writes the files that the power cut left into a folder, under their own names. The folder may
  // be the one the files came from only when every connection is closed. shm_garbage: also a -shm
  // file full of noise.
  void write_survivors(const std::string& folder, const PowerCut& cut,
                       bool shm_garbage = false) const;

 private:
  friend struct UnsyncedFile;
  enum class ChangeKind { room, sync, remove };
  // Counts the change. SQLITE_OK: do it. Otherwise answer with this code; recorded: but note it as
  // unsynced first.
  struct Verdict {
    int code = SQLITE_OK;
    bool recorded = true;
  };
  Verdict begin(ChangeKind kind, int power_cut_code);

  static int open(sqlite3_vfs* vfs, const char* path, sqlite3_file* file, int flags,
                  int* flags_out);
  static int remove(sqlite3_vfs* vfs, const char* path, int sync_folder);
  static UnsyncedVfs& of(sqlite3_vfs* vfs) { return *static_cast<UnsyncedVfs*>(vfs->pAppData); }

  std::string name_;
  sqlite3_vfs* real_;
  sqlite3_vfs vfs_{};
  mutable std::mutex mutex_;
  SimulatedDisk disk_;
  std::int64_t changes_ = 0;
  std::int64_t cut_at_ = 0, fail_writes_at_ = 0, fail_syncs_at_ = 0;  // 0: never
  int write_failure_ = SQLITE_FULL, sync_failure_ = SQLITE_IOERR_FSYNC;
  int errno_of_failures_ = 0;
  bool cut_ = false;
};

}  // namespace driftwise::faults
