// Cycles of the room that no channel shows, slow beside the rows.

#include <gtest/gtest.h>

#include "tests/unit/diagnosis/everyday_axis.h"

namespace driftwise::diagnosis {
namespace slow_cycle_test {
namespace {

// Four cycles and a half in eight hours, two thirds of the noise. Every octave of periods has the
// same odds: were it every frequency, most of them would be faster than ten minutes.
TEST(ASlowCycleOfTheRoom, IsNamed) {
  constexpr double kWave_mm = 3.2e-6, kPeriod_s = 6600;
  int named = 0;
  for (unsigned seed = 500; seed < 508; ++seed) {
    EverydayAxis axis(seed);
    for (std::size_t row = 0; row < EverydayAxis::kRows; ++row)
      axis.x_mm[row] +=
          kWave_mm * std::sin(2 * std::numbers::pi * axis.time_s[row] / kPeriod_s + seed);
    const auto found = axis.diagnosed();
    if (names_found(found) != std::vector<std::string>{"periodic_disturbance x"}) continue;
    ++named;
    EXPECT_NEAR(found.findings[0].parameters[0].value, kPeriod_s, 500) << seed;
  }
  EXPECT_GE(named, 7);
}

}  // namespace
}  // namespace slow_cycle_test
}  // namespace driftwise::diagnosis
