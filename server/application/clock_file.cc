#include "server/application/clock_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>

namespace driftwise::application {
namespace {

static_assert(std::endian::native == std::endian::little,
              "the file is little-endian and is mapped as it stands");
constexpr char kMagic[8] = {'D', 'W', 'C', 'L', 'O', 'C', 'K', '1'};

// Atomics without a lock have the layout of their value: the other process reads plain integers.
struct Mapped {
  char magic[8];
  std::atomic<std::uint64_t> sequence;
  std::atomic<std::int64_t> anchor_wall_ns, anchor_cell_ns;
  std::atomic<std::uint64_t> speed_bits;
};
static_assert(sizeof(Mapped) == 40 && std::atomic<std::uint64_t>::is_always_lock_free);

struct Descriptor {
  int fd;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
};

Result<void*> map(int fd, const std::string& path) {
  void* mapped = ::mmap(nullptr, sizeof(Mapped), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  if (mapped == MAP_FAILED)
    return fail(ErrorCode::internal, "CLOCK_FILE",
                fmt::format("{}: mmap: {}", path, std::strerror(errno)));
  return mapped;
}

}  // namespace

Result<std::unique_ptr<ClockFile>> ClockFile::open(const std::string& path) {
  const Descriptor file{::open(path.c_str(), O_RDWR | O_CLOEXEC)};
  if (file.fd < 0)
    return fail(ErrorCode::not_found, "NO_CLOCK_FILE",
                fmt::format("{}: {}: with [clock] speed other than 1 the simulated cell creates "
                            "this file: start it first",
                            path, std::strerror(errno)));
  struct stat status {};
  if (::fstat(file.fd, &status) != 0 || status.st_size != sizeof(Mapped))
    return fail(
        ErrorCode::data_loss, "BAD_CLOCK_FILE",
        fmt::format("{}: {} bytes, expected 40: delete it and start the simulated cell again", path,
                    status.st_size));
  auto mapped = map(file.fd, path);
  if (!mapped) return tl::unexpected(mapped.error());
  std::unique_ptr<ClockFile> opened(new ClockFile(*mapped));
  if (std::memcmp(static_cast<Mapped*>(*mapped)->magic, kMagic, sizeof kMagic) != 0)
    return fail(ErrorCode::data_loss, "BAD_CLOCK_FILE",
                fmt::format("{}: does not begin with DWCLOCK1", path));
  const double speed = opened->read().speed;
  if (!std::isfinite(speed) || speed <= 0)
    return fail(ErrorCode::data_loss, "BAD_CLOCK_FILE",
                fmt::format("{}: speed {}, expected a positive number", path, speed));
  return opened;
}

Result<std::unique_ptr<ClockFile>> ClockFile::create(const std::string& path,
                                                     const ClockAnchor& anchor) {
  const Descriptor file{::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)};
  if (file.fd < 0 || ::ftruncate(file.fd, sizeof(Mapped)) != 0)
    return fail(ErrorCode::internal, "CLOCK_FILE",
                fmt::format("{}: {}", path, std::strerror(errno)));
  auto mapped = map(file.fd, path);
  if (!mapped) return tl::unexpected(mapped.error());
  std::unique_ptr<ClockFile> created(new ClockFile(*mapped));
  static_cast<Mapped*>(*mapped)->sequence = 0;
  created->write(anchor);
  std::memcpy(static_cast<Mapped*>(*mapped)->magic, kMagic, sizeof kMagic);
  return created;
}

ClockAnchor SharedAnchor::read() const {
  while (true) {
    const auto before = sequence_.load();
    const ClockAnchor anchor{wall_ns_.load(), cell_ns_.load(), speed_.load()};
    if (before % 2 == 0 && sequence_.load() == before) return anchor;
  }
}

void SharedAnchor::write(const ClockAnchor& anchor) {
  ++sequence_;
  wall_ns_ = anchor.wall_ns;
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
    const ClockAnchor anchor{m->anchor_wall_ns.load(), m->anchor_cell_ns.load(),
                             std::bit_cast<double>(m->speed_bits.load())};
    if ((before % 2 == 0 && m->sequence.load() == before) || tries == 10000) return anchor;
  }
}

void ClockFile::write(const ClockAnchor& anchor) {
  auto* m = static_cast<Mapped*>(mapped_);
  const auto even = m->sequence.load() & ~std::uint64_t{1};
  m->sequence = even + 1;
  m->anchor_wall_ns = anchor.wall_ns;
  m->anchor_cell_ns = anchor.cell_ns;
  m->speed_bits = std::bit_cast<std::uint64_t>(anchor.speed);
  m->sequence = even + 2;
}

}  // namespace driftwise::application
