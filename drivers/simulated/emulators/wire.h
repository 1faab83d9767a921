#pragma once
// How bytes reach the other side: a stream has no message borders, and a client that relies on them
// is wrong. With chopping on, replies are cut into pieces at places that depend on the seed only,
// with a short pause between the pieces, and what waits together goes out together, across message
// borders.

#include <chrono>
#include <cstdint>
#include <random>

namespace driftwise::simulated {

struct WireOptions {
  bool chop = true;
  double chop_share = 0.3;  // of the writes that are cut at all
  std::chrono::microseconds pause{60};
  std::uint64_t seed = 1;
};

class WireChopper {
 public:
  WireChopper(const WireOptions& options, std::uint64_t salt)
      : options_(options), random_(options.seed * 0x9E3779B97F4A7C15u + salt) {}

  // How many of the waiting bytes to write now; the rest follows after pause().
  std::size_t next_piece(std::size_t waiting) {
    if (!options_.chop || waiting < 2) return waiting;
    const double dice = static_cast<double>(random_() >> 11) * 0x1p-53;
    if (dice >= options_.chop_share) return waiting;
    return 1 + static_cast<std::size_t>(random_() % (waiting - 1));
  }
  std::chrono::microseconds pause() const { return options_.pause; }

 private:
  WireOptions options_;
  std::mt19937_64 random_;
};

}  // namespace driftwise::simulated
