#pragma once
// A warm plant and its clock in seconds.

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "drivers/simulated/plant/file/make_plant.h"
#include "tests/support/plant_campaign.h"

namespace driftwise::simulated {

inline constexpr TimeNs kEpoch = 1'600'000'000'000'000'000;

inline TimeNs at(double seconds) {
  return kEpoch + static_cast<TimeNs>(std::llround(seconds * 1e9));
}

inline std::unique_ptr<LinearAxisPlant> warm_plant(std::uint64_t seed = 1,
                                                   std::vector<std::string> overrides = {}) {
  return make_plant(testing_support::linear_axis_plant_file(DRIFTWISE_SOURCE_DIR),
                    {.seed = seed, .overrides = std::move(overrides), .epoch_ns = kEpoch});
}

}  // namespace driftwise::simulated
