#pragma once

#include <vector>

namespace driftwise::stability {

// Values with their instants, in time order, none missing.
struct Samples {
  std::vector<double> time_s;
  std::vector<double> values;
};

}  // namespace driftwise::stability
