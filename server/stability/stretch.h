#pragma once
// Evenly spaced values out of readings of a channel.

#include <cstddef>

#include "server/stability/samples.h"

namespace driftwise::stability {

// The longest part of a series without a gap.
struct Stretch {
  std::size_t begin = 0, end = 0;  // rows of the series: [begin, end)
  double interval_s = 0;           // median distance of its values
  std::size_t size() const { return end - begin; }
};

// A gap is more than 1.5 times the median interval of the series. Fewer than 2 values: an empty
// stretch.
Stretch longest_stretch(const Samples& series);

}  // namespace driftwise::stability
