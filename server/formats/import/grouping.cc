#include "server/formats/import/grouping.h"

#include <cmath>
#include <map>

namespace driftwise::formats {
namespace {

bool lies_near(double a, double b, double within) {
  if (is_missing(a) || is_missing(b)) return is_missing(a) && is_missing(b);
  return std::abs(a - b) <= within;
}

// Leaders are kept by their first coordinate, so that few are looked at.
double key_of(double value) { return is_missing(value) ? -INFINITY : value; }

}  // namespace

std::vector<std::int64_t> group_rows(const std::vector<const DatasetColumn*>& columns,
                                     std::size_t rows, double within) {
  std::vector<std::int64_t> groups(rows);
  std::vector<std::size_t> leaders;             // first row of each group
  std::multimap<double, std::size_t> by_first;  // key -> index of the group
  for (std::size_t row = 0; row < rows; ++row) {
    const double key = key_of(columns.front()->values[row]);
    std::size_t best = leaders.size();
    // A hair wider than within: what is near is decided below.
    const double reach = within + 1e-12 * (std::abs(key) + within);
    const bool known = std::isfinite(key);
    auto at = known ? by_first.lower_bound(key - reach) : by_first.begin();
    const auto end = by_first.upper_bound(known ? key + reach : key);
    for (; at != end; ++at) {
      bool near = true;
      for (const auto* column : columns)
        near = near && lies_near(column->values[row], column->values[leaders[at->second]], within);
      if (near && at->second < best) best = at->second;
    }
    if (best == leaders.size()) {
      leaders.push_back(row);
      by_first.emplace(key, best);
    }
    groups[row] = static_cast<std::int64_t>(best) + 1;
  }
  return groups;
}

bool is_nth_group(std::int64_t group, int every) { return group % every == 0; }

bool is_hashed_group(std::int64_t group, double share, std::uint64_t seed) {
  std::uint64_t mixed =
      static_cast<std::uint64_t>(group) * 0x9E3779B97F4A7C15U + seed * 0xD1B54A32D192ED03U;
  mixed = (mixed ^ (mixed >> 30)) * 0xBF58476D1CE4E5B9U;
  mixed = (mixed ^ (mixed >> 27)) * 0x94D049BB133111EBU;
  mixed ^= mixed >> 31;
  constexpr double kTwoTo53 = 9007199254740992.0;
  return static_cast<double>(mixed >> 11) < share * kTwoTo53;
}

}  // namespace driftwise::formats
