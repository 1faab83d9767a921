#pragma once

#include <cstdint>
#include <random>
#include <string_view>
#include <vector>

namespace driftwise::foreign {

// Random numbers that are the same on every machine: mt19937_64 with transforms of our own.
//
// A stream is named, so that drawing one thing more in one stream never moves another stream.
class Random {
 public:
  Random(std::uint64_t seed, std::string_view stream);

  double uniform(double low, double high);
  double log_uniform(double low, double high);
  double normal();
  // Student's t with 3 degrees of freedom, scaled to unit variance.
  double student3();
  // Whole number 0 .. n-1; n >= 1.
  int below(int n);
  bool chance(double probability);
  // Plus one or minus one.
  double sign() { return chance(0.5) ? 1.0 : -1.0; }

  template <class T>
  const T& pick(const std::vector<T>& from) {
    return from[static_cast<std::size_t>(below(static_cast<int>(from.size())))];
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace driftwise::foreign
