#include "tests/faults/unsynced_vfs.h"

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <new>
#include <stdexcept>

namespace driftwise::faults {

// The default layer's file object stands behind this one in the memory that SQLite gives.
struct UnsyncedFile {
  sqlite3_file base;
  UnsyncedVfs* owner;
  std::string path;   // empty: a temporary file, passed through
  bool syncs_folder;  // with its first sync
  sqlite3_file* real;

  static UnsyncedFile& of(sqlite3_file* file) { return *reinterpret_cast<UnsyncedFile*>(file); }
  static const sqlite3_io_methods* methods();

  static int close(sqlite3_file* file) {
    UnsyncedFile& self = of(file);
    const int code =
        self.real->pMethods == nullptr ? SQLITE_OK : self.real->pMethods->xClose(self.real);
    self.path.~basic_string();
    return code;
  }
  static int read(sqlite3_file* file, void* into, int size, sqlite3_int64 offset) {
    UnsyncedFile& self = of(file);
    if (self.owner->power_is_cut()) return SQLITE_IOERR_READ;
    return self.real->pMethods->xRead(self.real, into, size, offset);
  }
  static int write(sqlite3_file* file, const void* bytes, int size, sqlite3_int64 offset) {
    UnsyncedFile& self = of(file);
    UnsyncedVfs& owner = *self.owner;
    if (self.path.empty()) return self.real->pMethods->xWrite(self.real, bytes, size, offset);
    const std::scoped_lock lock(owner.mutex_);
    const auto verdict = owner.begin(UnsyncedVfs::ChangeKind::room, SQLITE_IOERR_WRITE);
    if (verdict.recorded)
      owner.disk_.written(self.path, static_cast<std::uint64_t>(offset),
                          {static_cast<const char*>(bytes), static_cast<std::size_t>(size)});
    return verdict.code != SQLITE_OK ? verdict.code
                                     : self.real->pMethods->xWrite(self.real, bytes, size, offset);
  }
  static int truncate(sqlite3_file* file, sqlite3_int64 size) {
    UnsyncedFile& self = of(file);
    UnsyncedVfs& owner = *self.owner;
    if (self.path.empty()) return self.real->pMethods->xTruncate(self.real, size);
    const std::scoped_lock lock(owner.mutex_);
    const auto verdict = owner.begin(UnsyncedVfs::ChangeKind::room, SQLITE_IOERR_TRUNCATE);
    if (verdict.recorded) owner.disk_.truncated(self.path, static_cast<std::uint64_t>(size));
    return verdict.code != SQLITE_OK ? verdict.code
                                     : self.real->pMethods->xTruncate(self.real, size);
  }
  static int sync(sqlite3_file* file, int) {
    UnsyncedFile& self = of(file);
    UnsyncedVfs& owner = *self.owner;
    if (self.path.empty()) return SQLITE_OK;
    const std::scoped_lock lock(owner.mutex_);
    const auto verdict = owner.begin(UnsyncedVfs::ChangeKind::sync, SQLITE_IOERR_FSYNC);
    if (verdict.code != SQLITE_OK) return verdict.code;
    owner.disk_.sync_file(self.path);
    if (self.syncs_folder) owner.disk_.sync_folder();
    self.syncs_folder = false;
    return SQLITE_OK;
  }
  static int file_size(sqlite3_file* file, sqlite3_int64* size) {
    UnsyncedFile& self = of(file);
    if (self.owner->power_is_cut()) return SQLITE_IOERR_FSTAT;
    return self.real->pMethods->xFileSize(self.real, size);
  }

  // Locks and shared memory belong to the machine, not to the disk: passed through, so that closing
  // works.
  static int lock(sqlite3_file* f, int level) {
    return of(f).real->pMethods->xLock(of(f).real, level);
  }
  static int unlock(sqlite3_file* f, int level) {
    return of(f).real->pMethods->xUnlock(of(f).real, level);
  }
  static int check_lock(sqlite3_file* f, int* out) {
    return of(f).real->pMethods->xCheckReservedLock(of(f).real, out);
  }
  static int control(sqlite3_file* f, int op, void* argument) {
    return of(f).real->pMethods->xFileControl(of(f).real, op, argument);
  }
  static int sector_size(sqlite3_file* f) { return of(f).real->pMethods->xSectorSize(of(f).real); }
  static int characteristics(sqlite3_file* f) {
    return of(f).real->pMethods->xDeviceCharacteristics(of(f).real);
  }
  static int shm_map(sqlite3_file* f, int page, int size, int extend, void volatile** out) {
    return of(f).real->pMethods->xShmMap(of(f).real, page, size, extend, out);
  }
  static int shm_lock(sqlite3_file* f, int offset, int count, int flags) {
    return of(f).real->pMethods->xShmLock(of(f).real, offset, count, flags);
  }
  static void shm_barrier(sqlite3_file* f) { of(f).real->pMethods->xShmBarrier(of(f).real); }
  static int shm_unmap(sqlite3_file* f, int remove) {
    return of(f).real->pMethods->xShmUnmap(of(f).real, remove);
  }
};

const sqlite3_io_methods* UnsyncedFile::methods() {
  static const sqlite3_io_methods kMethods = {
      2,  // version 2: shared memory, but no memory mapping, which would write past this layer
      close,   read,     write,       truncate,  sync,        file_size,
      lock,    unlock,   check_lock,  control,   sector_size, characteristics,
      shm_map, shm_lock, shm_barrier, shm_unmap, nullptr,     nullptr};
  return &kMethods;
}

UnsyncedVfs::UnsyncedVfs(std::string name)
    : name_(std::move(name)), real_(sqlite3_vfs_find(nullptr)) {
  vfs_ = *real_;  // what is not named below passes to the default layer ...
  vfs_.pNext = nullptr;
  vfs_.zName = name_.c_str();
  vfs_.pAppData = this;
  vfs_.szOsFile = static_cast<int>(sizeof(UnsyncedFile)) + real_->szOsFile;
  vfs_.xOpen = &UnsyncedVfs::open;
  vfs_.xDelete = &UnsyncedVfs::remove;
  // ... through these: its functions read their own pAppData.
  vfs_.xAccess = [](sqlite3_vfs* v, const char* path, int flags, int* out) {
    return of(v).real_->xAccess(of(v).real_, path, flags, out);
  };
  vfs_.xFullPathname = [](sqlite3_vfs* v, const char* path, int size, char* out) {
    return of(v).real_->xFullPathname(of(v).real_, path, size, out);
  };
  if (sqlite3_vfs_register(&vfs_, 0) != SQLITE_OK)
    throw std::runtime_error("cannot register the test file system");
}

UnsyncedVfs::~UnsyncedVfs() { sqlite3_vfs_unregister(&vfs_); }

int UnsyncedVfs::open(sqlite3_vfs* vfs, const char* path, sqlite3_file* file, int flags,
                      int* flags_out) {
  UnsyncedVfs& self = of(vfs);
  auto* opened = new (file) UnsyncedFile{};
  opened->owner = &self;
  opened->real =
      reinterpret_cast<sqlite3_file*>(reinterpret_cast<char*>(file) + sizeof(UnsyncedFile));
  opened->base.pMethods = nullptr;  // SQLite calls xClose only when this is set
  constexpr int kTracked = SQLITE_OPEN_MAIN_DB | SQLITE_OPEN_WAL | SQLITE_OPEN_MAIN_JOURNAL;
  const bool tracked = path != nullptr && (flags & kTracked) != 0;

  const std::scoped_lock lock(self.mutex_);
  if (self.cut_) return SQLITE_CANTOPEN;
  const bool existed = tracked && std::filesystem::exists(path);
  if (tracked && existed && !self.disk_.knows(path)) {
    // Before any connection has it: closing this stream would drop a connection's POSIX locks.
    std::ifstream stream(path, std::ios::binary);
    self.disk_.found(path, std::string(std::istreambuf_iterator<char>(stream), {}));
  }
  if (tracked && !existed && (flags & SQLITE_OPEN_CREATE) != 0) {
    const auto verdict = self.begin(ChangeKind::room, SQLITE_CANTOPEN);
    if (verdict.recorded) self.disk_.created(path);
    if (verdict.code != SQLITE_OK) return verdict.code;
  }
  const int code = self.real_->xOpen(self.real_, path, opened->real, flags, flags_out);
  if (code != SQLITE_OK) return code;
  if (tracked) {
    opened->path = path;
    opened->syncs_folder = (flags & SQLITE_OPEN_CREATE) != 0 &&
                           (flags & (SQLITE_OPEN_WAL | SQLITE_OPEN_MAIN_JOURNAL)) != 0;
  }
  opened->base.pMethods = UnsyncedFile::methods();
  return SQLITE_OK;
}

int UnsyncedVfs::remove(sqlite3_vfs* vfs, const char* path, int sync_folder) {
  UnsyncedVfs& self = of(vfs);
  const std::scoped_lock lock(self.mutex_);
  const auto verdict = self.begin(ChangeKind::remove, SQLITE_IOERR_DELETE);
  if (verdict.recorded) self.disk_.removed(path);
  if (verdict.code != SQLITE_OK) return verdict.code;
  if (sync_folder != 0) self.disk_.sync_folder();
  return self.real_->xDelete(self.real_, path, 0);
}

UnsyncedVfs::Verdict UnsyncedVfs::begin(ChangeKind kind, int power_cut_code) {
  if (cut_) return {power_cut_code, false};
  ++changes_;
  if (cut_at_ != 0 && changes_ >= cut_at_) {
    cut_ = true;
    return {power_cut_code, true};
  }
  const bool room = kind == ChangeKind::room && fail_writes_at_ != 0 && changes_ >= fail_writes_at_;
  const bool sync = kind == ChangeKind::sync && fail_syncs_at_ != 0 && changes_ >= fail_syncs_at_;
  if (!room && !sync) return {};
  if (errno_of_failures_ != 0) errno = errno_of_failures_;
  return {room ? write_failure_ : sync_failure_, false};
}

std::int64_t UnsyncedVfs::changes() const {
  const std::scoped_lock lock(mutex_);
  return changes_;
}

void UnsyncedVfs::cut_power_at(std::int64_t change) {
  const std::scoped_lock lock(mutex_);
  cut_at_ = change;
}

bool UnsyncedVfs::power_is_cut() const {
  const std::scoped_lock lock(mutex_);
  return cut_;
}

void UnsyncedVfs::fail_writes_from(std::int64_t change, int code, int system_errno) {
  const std::scoped_lock lock(mutex_);
  errno_of_failures_ = system_errno;
  fail_writes_at_ = change;
  write_failure_ = code;
}

void UnsyncedVfs::fail_syncs_from(std::int64_t change, int code, int system_errno) {
  const std::scoped_lock lock(mutex_);
  errno_of_failures_ = system_errno;
  fail_syncs_at_ = change;
  sync_failure_ = code;
}

void UnsyncedVfs::heal() {
  const std::scoped_lock lock(mutex_);
  fail_writes_at_ = fail_syncs_at_ = 0;
}

void UnsyncedVfs::write_survivors(const std::string& folder, const PowerCut& cut,
                                  bool shm_garbage) const {
  const std::scoped_lock lock(mutex_);
  const auto left = disk_.after(cut);
  const auto write = [&](const std::string& name, const std::string& content) {
    std::ofstream stream(folder + "/" + name, std::ios::binary | std::ios::trunc);
    stream.write(content.data(), static_cast<std::streamsize>(content.size()));
  };
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (!entry.path().string().ends_with(".lock")) std::filesystem::remove(entry.path());
  std::mt19937_64 random(cut.seed + 1);
  for (const auto& [path, content] : left) {
    const std::string name = std::filesystem::path(path).filename().string();
    write(name, content);
    if (!shm_garbage || name.ends_with("-wal") || name.ends_with("-journal")) continue;
    std::string noise(32768, '\0');
    for (char& byte : noise) byte = static_cast<char>(random());
    write(name + "-shm", noise);
  }
}

}  // namespace driftwise::faults
