#pragma once
// Random numbers that are the same on every machine and standard library.

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <string_view>

namespace driftwise::simulated {

// One step of splitmix64 (Steele, Lea, Flood 2014): a good mixer of a counter.
constexpr std::uint64_t mixed(std::uint64_t value) {
  value += 0x9E3779B97F4A7C15ULL;
  value = (value ^ (value >> 30)) * 0xBF58476D1CE4E5B9ULL;
  value = (value ^ (value >> 27)) * 0x94D049BB133111EBULL;
  return value ^ (value >> 31);
}

// An independent stream per seed and name: adding one never shifts another. Splitmix64 as a counter
// generator.
class Random {
 public:
  Random(std::uint64_t seed, std::string_view stream) : state_(mixed(seed)) {
    for (const char c : stream) state_ = mixed(state_ ^ static_cast<unsigned char>(c));
  }
  double uniform() {  // in (0, 1)
    state_ += 0x9E3779B97F4A7C15ULL;
    return (static_cast<double>(mixed(state_) >> 11) + 0.5) * 0x1p-53;
  }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  double gaussian() {  // Box-Muller; the second value is kept
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double radius = std::sqrt(-2 * std::log(uniform()));
    const double angle = 2 * std::numbers::pi * uniform();
    spare_ = radius * std::sin(angle);
    has_spare_ = true;
    return radius * std::cos(angle);
  }

 private:
  std::uint64_t state_;
  double spare_ = 0;
  bool has_spare_ = false;
};

// The name of a stream of the index-th device of a kind: the first has the plain name.
inline std::string stream_of(std::string_view name, int index) {
  return std::string(name) + (index == 0 ? "" : "." + std::to_string(index + 1));
}

// An exponentially correlated Gaussian process on a fixed step, exact for any ratio of step to
// correlation time.
class Wander {
 public:
  Wander(double sigma, double correlation_s, double step_s, Random random)
      : keep_(std::exp(-step_s / correlation_s)),
        kick_(sigma * std::sqrt(1 - keep_ * keep_)),
        random_(random),
        value_(sigma * random_.gaussian()) {}
  double step() { return value_ = keep_ * value_ + kick_ * random_.gaussian(); }
  double value() const { return value_; }

 private:
  double keep_, kick_;
  Random random_;
  double value_;
};

}  // namespace driftwise::simulated
