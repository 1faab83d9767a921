#include "server/diagnosis/rows/place_groups.h"

#include <algorithm>

namespace driftwise::diagnosis {

std::vector<std::vector<std::size_t>> neighbouring_groups(
    const std::vector<std::vector<double>>& places, std::size_t count) {
  std::vector<std::vector<std::size_t>> groups(1);
  for (std::size_t i = 0; i < places.size(); ++i) groups[0].push_back(i);
  while (groups.size() < count) {
    auto largest = std::ranges::max_element(groups, {}, &std::vector<std::size_t>::size);
    if (largest->size() < 2) break;
    std::size_t side = 0;
    double longest = -1;
    for (std::size_t d = 0; d < places.front().size(); ++d) {
      const auto [low, high] =
          std::ranges::minmax(*largest, {}, [&](std::size_t i) { return places[i][d]; });
      if (places[high][d] - places[low][d] > longest) {
        longest = places[high][d] - places[low][d];
        side = d;
      }
    }
    std::ranges::stable_sort(*largest, {}, [&](std::size_t i) { return places[i][side]; });
    const auto middle = static_cast<std::ptrdiff_t>(largest->size() / 2);
    std::vector<std::size_t> second(largest->begin() + middle, largest->end());
    largest->resize(static_cast<std::size_t>(middle));
    groups.push_back(std::move(second));
  }
  return groups;
}

}  // namespace driftwise::diagnosis
