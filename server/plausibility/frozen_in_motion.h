#pragma once
// A length that gives the very same number from two places. Pure.

#include <cmath>
#include <map>
#include <string>
#include <vector>

namespace driftwise::plausibility {

class FrozenInMotion {
 public:
  // Noise alone changes the last digits: the same number after a way of this length is no length.
  static constexpr double kWay_mm = 0.001;

  // q: as read back now. true: frozen, as long as the number stays.
  bool is_frozen(const std::string& channel, double value, const std::vector<double>& q) {
    auto& seen = seen_[channel];
    if (seen.q.size() != q.size() || seen.value != value) {
      seen = {value, q, false};
      return false;
    }
    for (std::size_t i = 0; i < q.size(); ++i)
      seen.frozen = seen.frozen || std::abs(q[i] - seen.q[i]) > kWay_mm;
    return seen.frozen;
  }

 private:
  struct Seen {
    double value = 0;
    std::vector<double> q;
    bool frozen = false;
  };
  std::map<std::string, Seen> seen_;
};

}  // namespace driftwise::plausibility
