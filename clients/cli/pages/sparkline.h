#pragma once
// A series as one line of text.

#include <cstddef>
#include <span>
#include <string>

namespace driftwise::cli {

// One character per value, eight heights between the smallest and the largest; a missing value
// (NaN) leaves a blank. All the same: a line at the lowest height. More values than width: the
// newest.
std::string sparkline(std::span<const double> values, std::size_t width);

}  // namespace driftwise::cli
