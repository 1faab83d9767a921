#include "server/application/upkeep/clock_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>

#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::application {
namespace {

static_assert(std::endian::native == std::endian::little,
              "the file is little-endian and is mapped as it stands");
constexpr char kMagic[8] = {'D', 'W', 'C', 'L', 'O', 'C', 'K', '2'};

// Atomics without a lock have the layout of their value: the other process reads plain integers.
struct Mapped {
  char magic[8];
  std::atomic<std::uint64_t> sequence;
  std::atomic<std::int64_t> anchor_boot_ns, anchor_cell_ns;
  std::atomic<std::uint64_t> speed_bits;
  std::atomic<std::int64_t> anchor_wall_ns;
  unsigned char boot[16];
};
static_assert(sizeof(Mapped) == 64 && std::atomic<std::uint64_t>::is_always_lock_free);

struct Descriptor {
  int fd;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
};

// "3d5a...-..." as 16 bytes; what is no such name gives zeros.
std::array<unsigned char, 16> bytes_of(const std::string& boot) {
  std::array<unsigned char, 16> bytes{};
  std::size_t digits = 0;
  for (const char c : boot) {
    const int value = c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
    if (value < 0 || digits == 32) continue;
    bytes[digits / 2] = static_cast<unsigned char>(bytes[digits / 2] * 16 + value);
    ++digits;
  }
  return bytes;
}

Result<void*> map(int fd, const std::string& path) {
  void* mapped = ::mmap(nullptr, sizeof(Mapped), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  if (mapped == MAP_FAILED)
    return fail(ErrorCode::internal, reasons::kClockFile,
                fmt::format("{}: mmap: {}", path, std::strerror(errno)));
  return mapped;
}

}  // namespace

Result<std::unique_ptr<ClockFile>> ClockFile::open(const std::string& path,
                                                   const std::string& boot) {
  const Descriptor file{::open(path.c_str(), O_RDWR | O_CLOEXEC)};
  if (file.fd < 0)
    return fail(ErrorCode::not_found, reasons::kNoClockFile,
                fmt::format("{}: {}: with [clock] speed other than 1 the simulated cell creates "
                            "this file: start it first",
                            path, std::strerror(errno)));
  struct stat status {};
  if (::fstat(file.fd, &status) != 0 || status.st_size != sizeof(Mapped))
    return fail(
        ErrorCode::data_loss, reasons::kBadClockFile,
        fmt::format("{}: {} bytes, expected 64: delete it and start the simulated cell again", path,
                    status.st_size));
  DRIFTWISE_TRY(auto mapped, map(file.fd, path));
  std::unique_ptr<ClockFile> opened(new ClockFile(mapped));
  if (std::memcmp(static_cast<Mapped*>(mapped)->magic, kMagic, sizeof kMagic) != 0)
    return fail(
        ErrorCode::data_loss, reasons::kBadClockFile,
        fmt::format(
            "{}: does not begin with DWCLOCK2: delete it and start the simulated cell again",
            path));
  const auto start = bytes_of(boot);
  if (std::memcmp(static_cast<Mapped*>(mapped)->boot, start.data(), start.size()) != 0)
    return fail(ErrorCode::failed_precondition, reasons::kOldClockFile,
                fmt::format("{}: is of an earlier start of this computer: start the simulated cell "
                            "first, which carries its time on",
                            path));
  const double speed = opened->read().speed;
  if (!std::isfinite(speed) || speed <= 0)
    return fail(ErrorCode::data_loss, reasons::kBadClockFile,
                fmt::format("{}: speed {}, expected a positive number", path, speed));
  return opened;
}

Result<std::unique_ptr<ClockFile>> ClockFile::create(const std::string& path,
                                                     const ClockAnchor& anchor,
                                                     const std::string& boot) {
  const Descriptor file{::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)};
  if (file.fd < 0 || ::ftruncate(file.fd, sizeof(Mapped)) != 0)
    return fail(ErrorCode::internal, reasons::kClockFile,
                fmt::format("{}: {}", path, std::strerror(errno)));
  DRIFTWISE_TRY(auto mapped, map(file.fd, path));
  std::unique_ptr<ClockFile> created(new ClockFile(mapped));
  static_cast<Mapped*>(mapped)->sequence = 0;
  created->write(anchor);
  const auto start = bytes_of(boot);
  std::memcpy(static_cast<Mapped*>(mapped)->boot, start.data(), start.size());
  std::memcpy(static_cast<Mapped*>(mapped)->magic, kMagic, sizeof kMagic);
  return created;
}

ClockAnchor SharedAnchor::read() const {
  while (true) {
    const auto before = sequence_.load();
    const ClockAnchor anchor{boot_ns_.load(), cell_ns_.load(), speed_.load()};
    if (before % 2 == 0 && sequence_.load() == before) return anchor;
  }
}

void SharedAnchor::write(const ClockAnchor& anchor) {
  ++sequence_;
  boot_ns_ = anchor.boot_ns;
  cell_ns_ = anchor.cell_ns;
  speed_ = anchor.speed;
  ++sequence_;
}

ClockFile::~ClockFile() { ::munmap(mapped_, sizeof(Mapped)); }

ClockAnchor ClockFile::read() const {
  const auto* m = static_cast<const Mapped*>(mapped_);
  // Bounded: a writer that died in the middle must not hang us; its last values are then taken as
  // they stand.
  for (int tries = 0;; ++tries) {
    const auto before = m->sequence.load();
    const ClockAnchor anchor{m->anchor_boot_ns.load(), m->anchor_cell_ns.load(),
                             std::bit_cast<double>(m->speed_bits.load()), m->anchor_wall_ns.load()};
    if ((before % 2 == 0 && m->sequence.load() == before) || tries == 10000) return anchor;
  }
}

void ClockFile::write(const ClockAnchor& anchor) {
  auto* m = static_cast<Mapped*>(mapped_);
  const auto even = m->sequence.load() & ~std::uint64_t{1};
  m->sequence = even + 1;
  m->anchor_boot_ns = anchor.boot_ns;
  m->anchor_wall_ns = anchor.wall_ns;
  m->anchor_cell_ns = anchor.cell_ns;
  m->speed_bits = std::bit_cast<std::uint64_t>(anchor.speed);
  m->sequence = even + 2;
}

}  // namespace driftwise::application
