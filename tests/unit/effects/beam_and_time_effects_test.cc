// Periodic, data-time and beam effects against trigonometry, geometry and published refractivities.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "server/core/units.h"
#include "server/effects/effect.h"

namespace driftwise::effects {
namespace {

double value_of(const std::string& name, std::vector<Quantity> parameters,
                std::vector<double> inputs, double time_s = 0) {
  return find_effect(name)->make(parameters)->step(time_s, inputs);
}

TEST(Periodic, SineAndCosineOfALengthKeepTheirDigitsOverAMetre) {
  // 1e9 nm = 3160556 x 316.4 nm + 81.6 nm
  const double period_nm = 316.4, remainder_nm = 81.6;
  const double angle = 2 * std::numbers::pi * remainder_nm / period_nm;
  EXPECT_NEAR(value_of("sin", {{period_nm, "nm"}}, {1000.0}), std::sin(angle), 1e-8);
  EXPECT_NEAR(value_of("cos", {{period_nm, "nm"}}, {1000.0}), std::cos(angle), 1e-8);
}

TEST(Periodic, InTimeDoesNotDependOnAnyChannel) {
  EXPECT_NEAR(value_of("sin_t", {{600, "s"}}, {}, 150), 1.0, 1e-15);
  EXPECT_NEAR(value_of("cos_t", {{600, "s"}}, {}, 300), -1.0, 1e-15);
}

TEST(DataTime, AStepIsUpFromItsInstantOn) {
  EXPECT_EQ(value_of("step", {{14210, "s"}}, {}, 14209.999), 0);
  EXPECT_EQ(value_of("step", {{14210, "s"}}, {}, 14210), 1);
}

TEST(DataTime, DriftIsTimeInHours) { EXPECT_EQ(value_of("drift", {}, {}, 5400), 1.5); }

TEST(CosineError, IsHalfTheSquareOfASmallTilt) {
  const double tilt = rad_from_arcsec(50);
  EXPECT_NEAR(value_of("cosine", {}, {2.5, 50, 0}), 2.5 * tilt * tilt / 2, 1e-15);
  EXPECT_NEAR(value_of("cosine", {}, {2.5, 50, 30}),
              2.5 * (1 - std::cos(tilt) * std::cos(rad_from_arcsec(30))), 1e-15);
}

TEST(AirIndex, AgreesWithPublishedRefractivitiesOfDryAir) {
  // Ciddor, Applied Optics 35 (1996) 1566, table 1: (n-1) 1e8 at 633 nm, 450 ppm CO2; the two
  // equations agree to some parts in 1e8.
  EXPECT_NEAR(value_of("air_index", {}, {20, 1000, 0}), 268.244, 0.03);
  EXPECT_NEAR(value_of("air_index", {}, {20, 800, 0}), 214.580, 0.03);
  EXPECT_NEAR(value_of("air_index", {}, {10, 1000, 0}), 277.747, 0.03);
  EXPECT_NEAR(value_of("air_index", {}, {30, 1000, 0}), 259.372, 0.03);
}

TEST(AirIndex, MovesAsThePublishedStudySays) {
  // Appendix A.1: 0.3 K: 2.8e-7; 50 Pa: 1.4e-7; 3 % humidity: 0.3e-7
  const double at = value_of("air_index", {}, {20, 1013.25, 50});
  EXPECT_NEAR(at - value_of("air_index", {}, {20.3, 1013.25, 50}), 0.28, 0.01);
  EXPECT_NEAR(value_of("air_index", {}, {20, 1013.75, 50}) - at, 0.14, 0.01);
  EXPECT_NEAR(at - value_of("air_index", {}, {20, 1013.25, 53}), 0.03, 0.01);
}

TEST(EffectKinds, WithoutMemoryGiveTheSameWhateverCameBefore) {
  int memoryless = 0;
  for (const auto& kind : effect_kinds()) {
    if (!kind.memoryless) continue;
    ++memoryless;
    std::vector<Quantity> parameters;
    for (const auto& one : kind.parameters) parameters.push_back({0.3, one.unit});
    const std::vector<double> now(static_cast<std::size_t>(kind.symbol_count), 0.7),
        before(now.size(), -4.0);
    const auto fresh = kind.make(parameters), used = kind.make(parameters);
    for (int k = 0; k < 5; ++k) used->step(100.0 * k, before);
    EXPECT_EQ(used->step(500, now), fresh->step(0, now)) << kind.name;
  }
  EXPECT_EQ(memoryless, 5);  // sin, cos, cosine, air_index, contact
}

TEST(EffectKinds, EachHasASentenceAndAUsage) {
  for (const auto& kind : effect_kinds()) {
    EXPECT_FALSE(kind.sentence.empty()) << kind.name;
    EXPECT_EQ(usage(kind).rfind(kind.name + "(", 0), 0u);
  }
  EXPECT_EQ(usage(*find_effect("step")), "step(time s)");
  EXPECT_EQ(usage(*find_effect("drift")), "drift()");
}

}  // namespace
}  // namespace driftwise::effects
