#include "server/stability/rest.h"

#include <cmath>
#include <span>

namespace driftwise::stability {
namespace {

constexpr std::size_t kBlocks = 30;  // per window
constexpr double kCoverage = 2;

std::optional<Drift> drift_between(const Samples& blocks, std::size_t begin, std::size_t end) {
  return drift_of(std::span(blocks.time_s).subspan(begin, end - begin),
                  std::span(blocks.values).subspan(begin, end - begin));
}

}  // namespace

RestVerdict rest_of(const Samples& series, double window_s, double limit_per_h) {
  RestVerdict verdict;
  const Samples blocks = block_means(series, window_s / kBlocks);
  const std::size_t count = blocks.values.size();
  if (count == 0) return verdict;
  verdict.change = blocks.values.back() - blocks.values.front();
  if (count < kBlocks) return verdict;
  verdict.now = drift_between(blocks, count - kBlocks, count);
  // From the last window back: the first one that is beyond the limit ends the stretch.
  std::size_t begin = count - kBlocks + 1;
  while (begin > 0) {
    const auto window = drift_between(blocks, begin - 1, begin - 1 + kBlocks);
    if (!window || std::abs(window->rate_per_h) - kCoverage * window->u_rate_per_h > limit_per_h)
      break;
    --begin;
  }
  // Half a block at a time would be finer than what a window can tell.
  for (; begin + kBlocks <= count; ++begin) {
    const auto whole = drift_between(blocks, begin, count);
    if (!whole || std::abs(whole->rate_per_h) + kCoverage * whole->u_rate_per_h > limit_per_h)
      continue;
    verdict.warm_at_s = blocks.time_s[begin];
    break;
  }
  return verdict;
}

}  // namespace driftwise::stability
