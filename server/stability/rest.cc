#include "server/stability/rest.h"

#include <cmath>
#include <span>

namespace driftwise::stability {
namespace {

constexpr double kBlocks = 30;  // per window
constexpr double kCoverage = 2;
constexpr double kLeastCovered = 0.9;  // of the first window of a stretch
constexpr double kLongestHole = 0.25;  // of a window; a longer one ends the stretch

std::optional<Drift> drift_between(const Samples& blocks, std::size_t begin, std::size_t end) {
  return drift_of(std::span(blocks.time_s).subspan(begin, end - begin),
                  std::span(blocks.values).subspan(begin, end - begin));
}

// First block behind the last hole that is too long.
std::size_t begin_without_holes(const Samples& blocks, double longest_s) {
  std::size_t begin = blocks.time_s.size() - 1;
  while (begin > 0 && blocks.time_s[begin] - blocks.time_s[begin - 1] <= longest_s) --begin;
  return begin;
}

// First block of the window that ends with block `last`; none: the window begins before `begin`.
// Blocks are counted by their times, for a slow channel fills few of them.
std::optional<std::size_t> window_begin(const Samples& blocks, std::size_t begin, std::size_t last,
                                        double window_s) {
  const double end_s = blocks.time_s[last];
  std::size_t first = last;
  while (first > begin && blocks.time_s[first - 1] > end_s - window_s) --first;
  if (first == begin && end_s - blocks.time_s[first] < kLeastCovered * window_s)
    return std::nullopt;
  return first;
}

}  // namespace

RestVerdict rest_of(const Samples& series, double window_s, double limit_per_h) {
  RestVerdict verdict;
  const Samples blocks = block_means(series, window_s / kBlocks);
  const std::size_t count = blocks.values.size();
  if (count == 0) return verdict;
  verdict.change = blocks.values.back() - blocks.values.front();
  std::size_t begin = begin_without_holes(blocks, kLongestHole * window_s);
  const auto newest = window_begin(blocks, begin, count - 1, window_s);
  if (!newest) return verdict;
  verdict.now = drift_between(blocks, *newest, count);
  // From the last window back: the first one that is beyond the limit ends the stretch.
  for (std::size_t end = count; end > begin; --end) {
    const auto first = window_begin(blocks, begin, end - 1, window_s);
    if (!first) break;
    const auto window = drift_between(blocks, *first, end);
    if (window && std::abs(window->rate_per_h) - kCoverage * window->u_rate_per_h <= limit_per_h)
      continue;
    begin = *first + 1;
    break;
  }
  // Half a block at a time would be finer than what a window can tell.
  for (; begin <= *newest; ++begin) {
    const auto whole = drift_between(blocks, begin, count);
    if (!whole || std::abs(whole->rate_per_h) + kCoverage * whole->u_rate_per_h > limit_per_h)
      continue;
    verdict.warm_at_s = blocks.time_s[begin];
    break;
  }
  return verdict;
}

}  // namespace driftwise::stability
