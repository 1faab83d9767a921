#include "drivers/simulated/emulators/cell/sim_clock.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <string>

#include "drivers/simulated/emulators/switches.h"
#include "drivers/simulated/emulators/text.h"

namespace driftwise::simulated {
namespace {

static_assert(std::endian::native == std::endian::little, "the clock file is little-endian");

constexpr char kMagic[] = "DWCLOCK2";
constexpr std::size_t kSize = 64, kSequenceAt = 8, kBootAt = 16, kCellAt = 24, kSpeedAt = 32,
                      kWallAt = 40, kStartAt = 48;

// Another process writes: each word is read once, as a whole.
std::uint64_t word_at(const void* base, std::size_t offset) {
  const auto* word =
      reinterpret_cast<const std::uint64_t*>(static_cast<const char*>(base) + offset);
  return __atomic_load_n(word, __ATOMIC_ACQUIRE);
}

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& what) {
  throw SetupError(file.string() + ": " + what);
}

// This start of the computer as 16 bytes; zeros where it is not known.
std::array<unsigned char, 16> this_start() {
  std::array<unsigned char, 16> bytes{};
  std::ifstream in("/proc/sys/kernel/random/boot_id");
  std::string text;
  in >> text;
  std::erase(text, '-');
  for (std::size_t i = 0; i < bytes.size() && 2 * i + 2 <= text.size(); ++i)
    bytes[i] = static_cast<unsigned char>(std::stoi(text.substr(2 * i, 2), nullptr, 16));
  return bytes;
}

void create(const std::filesystem::path& file, TimeNs boot, TimeNs wall, TimeNs cell,
            double speed) {
  std::array<char, kSize> bytes{};
  const auto start = this_start();
  std::memcpy(bytes.data(), kMagic, 8);
  std::memcpy(bytes.data() + kBootAt, &boot, 8);
  std::memcpy(bytes.data() + kWallAt, &wall, 8);
  std::memcpy(bytes.data() + kStartAt, start.data(), start.size());
  std::memcpy(bytes.data() + kCellAt, &cell, 8);
  std::memcpy(bytes.data() + kSpeedAt, &speed, 8);
  // Written aside and moved: nobody ever sees half a clock.
  const std::filesystem::path aside = file.string() + ".new";
  const int out = ::open(aside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (out < 0) refuse(aside, std::string("cannot be created: ") + std::strerror(errno));
  const bool written = ::write(out, bytes.data(), kSize) == static_cast<ssize_t>(kSize);
  ::close(out);
  if (!written || ::rename(aside.c_str(), file.c_str()) != 0)
    refuse(file, std::string("cannot be written: ") + std::strerror(errno));
}

}  // namespace

SimClock::SimClock(const std::filesystem::path& file, TimeNs epoch, double speed) : file_(file) {
  if (!std::filesystem::exists(file)) {
    const TimeNs wall = wall_now();
    create(file, boot_now(), wall, epoch == 0 ? wall : epoch, speed);
  }
  map(file);
  const auto start = this_start();
  if (std::memcmp(static_cast<const char*>(mapped_) + kStartAt, start.data(), start.size()) == 0)
    return;
  const Anchor old = anchor();
  const TimeNs wall = wall_now();
  const auto away = static_cast<double>(std::max<TimeNs>(0, wall - old.wall_ns));
  create(file, boot_now(), wall, old.cell_ns + std::llround(away * old.speed), old.speed);
  ::munmap(const_cast<void*>(mapped_), kSize);
  map(file);
}

void SimClock::map(const std::filesystem::path& file) {
  mapped_ = nullptr;
  const int in = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat status {};
  if (in < 0 || ::fstat(in, &status) != 0) {
    const int reason = errno;
    if (in >= 0) ::close(in);
    refuse(file, std::string("cannot be opened: ") + std::strerror(reason));
  }
  void* mapped =
      status.st_size == kSize ? ::mmap(nullptr, kSize, PROT_READ, MAP_SHARED, in, 0) : MAP_FAILED;
  ::close(in);
  if (mapped == MAP_FAILED || std::memcmp(mapped, kMagic, 8) != 0)
    refuse(file, "found no clock, expected 64 bytes that begin with DWCLOCK2: remove it");
  mapped_ = mapped;
  const double found = anchor().speed;
  if (!std::isfinite(found) || found <= 0) {
    ::munmap(mapped, kSize);
    refuse(file, "found speed " + shortest(found) + ", expected a number above 0: remove it");
  }
}

SimClock::~SimClock() {
  if (mapped_ != nullptr) ::munmap(const_cast<void*>(mapped_), kSize);
}

SimClock::Anchor SimClock::anchor() const {
  if (mapped_ == nullptr) return own_;
  // A writer that died in the middle leaves an odd sequence for ever: after some tries its values
  // are taken as they are.
  for (int tries = 0;; ++tries) {
    const std::uint64_t before = word_at(mapped_, kSequenceAt);
    const Anchor seen{static_cast<std::int64_t>(word_at(mapped_, kBootAt)),
                      static_cast<std::int64_t>(word_at(mapped_, kCellAt)),
                      std::bit_cast<double>(word_at(mapped_, kSpeedAt)),
                      static_cast<std::int64_t>(word_at(mapped_, kWallAt))};
    if ((before % 2 == 0 && word_at(mapped_, kSequenceAt) == before) || tries > 1000) return seen;
  }
}

TimeNs SimClock::now() {
  const TimeNs boot = boot_now();
  const Anchor from = anchor();
  // Whole nanoseconds at speed 1; at another speed a double is exact to some ns over days.
  const TimeNs elapsed = boot - from.boot_ns;
  const TimeNs cell = from.speed == 1
                          ? from.cell_ns + elapsed
                          : from.cell_ns + std::llround(static_cast<double>(elapsed) * from.speed);
  last_ = std::max(last_, cell);
  return last_;
}

void SimClock::set_forward(TimeNs instant) {
  if (instant <= now()) return;
  const Anchor old = anchor();
  if (mapped_ == nullptr) {
    own_ = {boot_now(), instant, old.speed, wall_now()};
    return;
  }
  create(file_, boot_now(), wall_now(), instant, old.speed);
  ::munmap(const_cast<void*>(mapped_), kSize);
  map(file_);
}

double SimClock::speed() const { return anchor().speed; }

std::chrono::nanoseconds SimClock::wall_until(TimeNs instant) {
  const TimeNs left = instant - now();
  if (left <= 0) return std::chrono::nanoseconds(0);
  return std::chrono::nanoseconds(std::llround(static_cast<double>(left) / speed()));
}

namespace {
TimeNs read_clock(clockid_t which) {
  timespec time{};
  ::clock_gettime(which, &time);
  return static_cast<TimeNs>(time.tv_sec) * 1'000'000'000 + time.tv_nsec;
}
}  // namespace

TimeNs SimClock::wall_now() { return read_clock(CLOCK_REALTIME); }
TimeNs SimClock::boot_now() { return read_clock(CLOCK_BOOTTIME); }

}  // namespace driftwise::simulated
