#include "tests/hidden_effects/foreign/random.h"

#include <cmath>
#include <numbers>

namespace driftwise::foreign {
namespace {

// splitmix64 finaliser; source: Steele, Lea, Flood, OOPSLA 2014.
std::uint64_t mixed(std::uint64_t value) {
  value += 0x9e3779b97f4a7c15ULL;
  value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9ULL;
  value = (value ^ (value >> 27)) * 0x94d049bb133111ebULL;
  return value ^ (value >> 31);
}

std::uint64_t seed_of(std::uint64_t seed, std::string_view stream) {
  std::uint64_t state = mixed(seed);
  for (const char letter : stream) {
    state = mixed(state ^ static_cast<std::uint64_t>(static_cast<unsigned char>(letter)));
  }
  return state;
}

}  // namespace

Random::Random(std::uint64_t seed, std::string_view stream) : engine_(seed_of(seed, stream)) {}

double Random::uniform(double low, double high) {
  const double unit = static_cast<double>(engine_() >> 11) * 0x1.0p-53;
  return low + (high - low) * unit;
}

double Random::log_uniform(double low, double high) {
  return std::exp(uniform(std::log(low), std::log(high)));
}

double Random::normal() {
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform(0.0, 1.0)));
  return radius * std::cos(2.0 * std::numbers::pi * uniform(0.0, 1.0));
}

double Random::student3() {
  const double top = normal();
  double square = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double part = normal();
    square += part * part;
  }
  return top / std::sqrt(square / 3.0) / std::sqrt(3.0);
}

int Random::below(int n) {
  const int drawn = static_cast<int>(uniform(0.0, static_cast<double>(n)));
  return drawn < n ? drawn : n - 1;
}

bool Random::chance(double probability) { return uniform(0.0, 1.0) < probability; }

}  // namespace driftwise::foreign
