#pragma once
// Values of a dataset that no instrument can have measured: infinite, or beyond kLargest. A record
// may hold them from before they were rejected; everything that computes takes them as missing.

#include <optional>
#include <string>

#include "server/core/data/dataset.h"

namespace driftwise {

// Squares and products of four of them are still finite.
inline constexpr double kLargestUsable = 1e75;

struct UsableDataset {
  Dataset data;          // those values as kMissing
  std::string sentence;  // which rows, counted from 1, with the first values: for a warning
};

// None: every value is usable, and nothing was copied.
std::optional<UsableDataset> without_unusable(const Dataset& dataset);

}  // namespace driftwise
