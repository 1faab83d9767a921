#include "drivers/transport/back_off.h"

#include <algorithm>

namespace driftwise::transport {

BackOff::Milliseconds BackOff::after_failure() {
  if (failures_++ == 0) return Milliseconds(0);
  const int doublings = std::min(failures_ - 2, 20);
  const auto whole =
      std::min<std::int64_t>(bounds_.first.count() << doublings, bounds_.longest.count());
  const double factor =
      0.5 + 0.5 * static_cast<double>(random_() - std::minstd_rand::min()) /
                static_cast<double>(std::minstd_rand::max() - std::minstd_rand::min());
  return Milliseconds(static_cast<std::int64_t>(static_cast<double>(whole) * factor));
}

std::uint32_t seed_from(std::string_view text) {
  std::uint32_t hash = 2166136261u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  return hash;
}

}  // namespace driftwise::transport
