#pragma once
// Which buckets a series is answered in, and what falls into them. Pure.

#include <cstdint>
#include <vector>

#include "server/core/records/watch_records.h"
#include "storage/readings/series_block.h"

namespace driftwise::storage {

// In the year 2261. An instant and a unit of any level add up within 64 bits.
constexpr std::int64_t kFarthestNs = 9'200'000'000'000'000'000;

struct SeriesGrid {
  std::int64_t from_ns = 0, bucket_ns = 1;
  std::size_t buckets = 0;
  int level = 0;  // of the blocks to read; 0: the values themselves

  // The end of the last bucket, at most kFarthestNs.
  std::int64_t to_ns() const {
    const auto count = static_cast<std::int64_t>(buckets);
    return count > (kFarthestNs - from_ns) / bucket_ns ? kFarthestNs : from_ns + bucket_ns * count;
  }
  std::size_t index(std::int64_t at_ns) const {
    return static_cast<std::size_t>((at_ns - from_ns) / bucket_ns);
  }
  bool holds(std::int64_t at_ns) const { return at_ns >= from_ns && at_ns < to_ns(); }
};

// The coarsest level of which at least four buckets go into one asked for; the answer's buckets are
// then whole multiples of it, at most a quarter longer than asked for, from a multiple of their
// length on. asked >= 1, to after from. What is before 1970 or after kFarthestNs is left out.
SeriesGrid series_grid(std::int64_t from_ns, std::int64_t to_ns, int asked);

// The buckets of one channel as the port gives them.
SeriesColumn column_of(std::string channel, const std::vector<Bucket>& buckets);

}  // namespace driftwise::storage
