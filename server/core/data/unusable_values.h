#pragma once
// Values of a dataset that no instrument can have measured: infinite, or beyond kLargestUsable. A
// record may hold them from before they were rejected, and files of other programs hold the
// overflow (9.9e37) and the missing value (9.91e37) of SCPI instruments. Everything that computes
// takes them as missing.

#include <optional>
#include <string>

#include "server/core/data/dataset.h"

namespace driftwise {

// Below 9.9e37: SCPI-99, volume 1, section 7.2.1. Products of ten such values are still finite.
inline constexpr double kLargestUsable = 1e30;

struct UsableDataset {
  Dataset data;          // those values as kMissing
  std::string sentence;  // which rows, counted from 1, with the first values: for a warning
};

// None: every value is usable, and nothing was copied.
std::optional<UsableDataset> without_unusable(const Dataset& dataset);

}  // namespace driftwise
