#include "server/stability/stretch.h"

#include <algorithm>

namespace driftwise::stability {

Stretch longest_stretch(const Samples& series) {
  constexpr double kGap = 1.5;
  Stretch longest;
  const std::size_t count = series.time_s.size();
  if (count < 2) return longest;
  std::vector<double> steps;
  for (std::size_t i = 1; i < count; ++i) steps.push_back(series.time_s[i] - series.time_s[i - 1]);
  std::vector<double> sorted = steps;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const double interval_s = *middle;
  std::size_t begin = 0;
  for (std::size_t i = 1; i <= count; ++i) {
    if (i < count && steps[i - 1] <= kGap * interval_s) continue;
    if (i - begin > longest.size()) longest = {begin, i, interval_s};
    begin = i;
  }
  return longest;
}

}  // namespace driftwise::stability
