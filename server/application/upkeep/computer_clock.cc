#include "server/application/upkeep/computer_clock.h"

#include <time.h>

#include <chrono>
#include <fstream>

namespace driftwise::application {
namespace {

std::int64_t since_boot_ns() {
  timespec time{};
  ::clock_gettime(CLOCK_BOOTTIME, &time);
  return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

std::int64_t wall_clock_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace

ComputerClock this_computer() {
  std::string boot;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> boot;
  return {since_boot_ns, wall_clock_ns, std::move(boot)};
}

std::int64_t wall_ahead_ns(const ComputerClock& computer) {
  constexpr int kMostTries = 20;
  constexpr std::int64_t kNarrow_ns = 20'000;
  std::int64_t narrowest_ns = INT64_MAX, ahead_ns = 0;
  for (int i = 0; i < kMostTries && narrowest_ns > kNarrow_ns; ++i) {
    const std::int64_t before = computer.boot_ns();
    const std::int64_t wall = computer.wall_ns();
    const std::int64_t width = computer.boot_ns() - before;
    if (width >= narrowest_ns) continue;
    narrowest_ns = width;
    ahead_ns = wall - before - width / 2;
  }
  return ahead_ns;
}

}  // namespace driftwise::application
