#pragma once

#include <string>

namespace driftwise {

// [thinning] of the cell file: raw readings of the environment that are older become one row per
// interval. docs/database.md, "Thinning".
struct ThinningRules {
  double after_days = 0;         // 0: only when somebody asks
  double every_s = 60;           // length of an interval
  std::string reducer = "mean";  // "mean", "min", "max"
};

}  // namespace driftwise
