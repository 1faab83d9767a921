#pragma once

#include <chrono>
#include <cstdint>
#include <random>
#include <string_view>

namespace driftwise::transport {

// How long to stay away from a device that could not be reached: doubles with every failure up to a
// bound, each wait multiplied by a seeded random factor in [0.5, 1] so that many devices do not
// knock at the same instant. The first attempt after a success is immediate: most broken lines come
// back at once. Wall time.
class BackOff {
 public:
  using Milliseconds = std::chrono::milliseconds;
  struct Bounds {
    Milliseconds first{100}, longest{5000};
  };

  BackOff(std::uint32_t seed, Bounds bounds) : random_(seed), bounds_(bounds) {}

  Milliseconds after_failure();  // the wait before the next attempt
  void after_success() { failures_ = 0; }
  int failures() const { return failures_; }

 private:
  std::minstd_rand random_;
  Bounds bounds_;
  int failures_ = 0;
};

std::uint32_t seed_from(std::string_view text);  // FNV-1a: the same everywhere

}  // namespace driftwise::transport
