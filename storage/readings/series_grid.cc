#include "storage/readings/series_grid.h"

#include <algorithm>

namespace driftwise::storage {
namespace {

// A quotient of two numbers that are not negative, rounded up; no sum in it can overflow.
std::int64_t quotient_up(std::int64_t number, std::int64_t by) {
  return number / by + (number % by == 0 ? 0 : 1);
}

}  // namespace

SeriesGrid series_grid(std::int64_t from_ns, std::int64_t to_ns, int asked) {
  constexpr std::int64_t kTickNs = 1000;  // instants are kept to a microsecond
  from_ns = std::clamp<std::int64_t>(from_ns, 0, kFarthestNs);
  to_ns = std::clamp<std::int64_t>(to_ns, from_ns, kFarthestNs);
  SeriesGrid grid;
  const std::int64_t wanted = std::max(kTickNs, quotient_up(to_ns - from_ns, asked));
  while (grid.level < kSummaryLevels && 4 * bucket_ns(grid.level + 1) <= wanted) ++grid.level;
  const std::int64_t unit = grid.level == 0 ? kTickNs : bucket_ns(grid.level);
  grid.bucket_ns = quotient_up(wanted, unit) * unit;
  grid.from_ns = floor_to(from_ns, grid.level == 0 ? kTickNs : grid.bucket_ns);
  grid.buckets = static_cast<std::size_t>(quotient_up(to_ns - grid.from_ns, grid.bucket_ns));
  return grid;
}

SeriesColumn column_of(std::string channel, const std::vector<Bucket>& buckets) {
  SeriesColumn out;
  out.channel = std::move(channel);
  for (auto* values : {&out.min, &out.max, &out.mean}) values->reserve(buckets.size());
  out.count.reserve(buckets.size());
  for (const Bucket& bucket : buckets) {
    const bool empty = bucket.count == 0;
    out.min.push_back(empty ? kMissing : bucket.min);
    out.max.push_back(empty ? kMissing : bucket.max);
    out.mean.push_back(empty ? kMissing : bucket.sum / bucket.count);
    out.count.push_back(static_cast<std::int64_t>(bucket.count));
  }
  return out;
}

}  // namespace driftwise::storage
