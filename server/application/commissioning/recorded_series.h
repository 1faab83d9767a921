#pragma once
// Values of channels as the record has them.

#include <string>
#include <vector>

#include "server/core/ports/store.h"
#include "server/stability/samples.h"

namespace driftwise::application {

struct RecordedSeries {
  std::string channel;
  stability::Samples samples;  // seconds since from; rejected and missing values are left out
};

inline constexpr int kMostReadings = 400'000;
// Blocks: on the store's thread. device: gives the channels. The newest kMostReadings
// at most.
Result<std::vector<RecordedSeries>> recorded_series(Store& store, const std::string& device,
                                                    const std::vector<std::string>& channels,
                                                    CellTime from, CellTime to);

}  // namespace driftwise::application
