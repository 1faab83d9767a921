#include "server/diagnosis/rows/places.h"

#include <algorithm>
#include <cmath>

namespace driftwise::diagnosis {
namespace {

constexpr double kGap = 7e-4, kWidest = 2e-3;  // of the channel's range
constexpr std::size_t kFewestVisits = 3;

}  // namespace

std::vector<double> by_places(const std::vector<double>& values) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (std::isfinite(values[i])) order.push_back(i);
  std::vector<double> result = values;
  if (order.empty()) return result;
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return values[i]; });
  const double range = values[order.back()] - values[order.front()];
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin + 1;
    double sum = values[order[begin]];
    for (; end < order.size() && values[order[end]] - values[order[end - 1]] < kGap * range; ++end)
      sum += values[order[end]];
    if (end - begin >= kFewestVisits &&
        values[order[end - 1]] - values[order[begin]] < kWidest * range)
      for (std::size_t k = begin; k < end; ++k)
        result[order[k]] = sum / static_cast<double>(end - begin);
    begin = end;
  }
  return result;
}

}  // namespace driftwise::diagnosis
