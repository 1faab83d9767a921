#pragma once
// [[keep_out]] of a cell file: the smallest distance that two robots keep from each other. Plain
// data.

#include <string>
#include <vector>

#include "server/core/channel.h"

namespace driftwise {

struct KeepOutTerm {
  Channel axis;       // mn.q3_mm
  double per_mm = 0;  // change of the distance, mm per mm of the axis
};

// distance = at_zero_mm + sum of per_mm * axis, mm: linear, so that its smallest value while axes
// move at once is at a corner of the box between the two ends of the move.
struct KeepOutDescription {
  std::string name;                 // "tips in z"
  double min_mm = 0;                // never nearer
  double at_zero_mm = 0;            // with all axes at 0: at least min_mm
  std::vector<KeepOutTerm> terms;   // axes of two robots at least
  std::vector<std::string> robots;  // ids of these, in the order of the terms
};

}  // namespace driftwise
