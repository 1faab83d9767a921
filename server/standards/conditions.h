#pragma once
// The temperatures during a test, which every one of these standards wants beside its figures.

#include <string>
#include <vector>

#include "server/core/data/dataset.h"

namespace driftwise::standards {

struct TemperatureRange {
  std::string channel;  // "t07_degC"
  double first_degc = kMissing, last_degc = kMissing, min_degc = kMissing, max_degc = kMissing;
};

struct Conditions {
  double duration_s = kMissing;                // from the first to the last row; kMissing: untimed
  std::vector<TemperatureRange> temperatures;  // every channel in degC or K that has values
};

// Of the rows in use.
Conditions conditions_of(const Dataset& dataset);

}  // namespace driftwise::standards
