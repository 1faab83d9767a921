#include "server/core/unit_conversion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "server/core/channel.h"
#include "server/core/units.h"

namespace driftwise {
namespace {

double converted(double value, const char* from, const char* to) {
  const auto conversion = unit_conversion(from, to);
  EXPECT_TRUE(conversion) << from << " -> " << to;
  return conversion ? (*conversion)(value) : NAN;
}

TEST(UnitConversion, TakesWholeMultiplesExactly) {
  EXPECT_EQ(converted(0.5, "m", "mm"), 500);
  EXPECT_EQ(converted(500, "mm", "m"), 0.5);
  EXPECT_EQ(converted(1, "inch", "mm"), 25.4);
  EXPECT_EQ(converted(2, "deg", "arcsec"), 7200);
  EXPECT_EQ(converted(7200, "arcsec", "deg"), 2);
  EXPECT_EQ(converted(1, "bar", "hPa"), 1000);
  EXPECT_EQ(converted(1.5, "h", "s"), 5400);
}

TEST(UnitConversion, KnowsTemperaturesByTheirZeros) {
  EXPECT_NEAR(converted(293.15, "K", "degC"), 20, 1e-12);
  EXPECT_NEAR(converted(68, "degF", "degC"), 20, 1e-12);
  EXPECT_NEAR(converted(20, "degC", "degF"), degf_from_degc(20), 1e-12);
}

TEST(UnitConversion, TurnsAnglesByPi) {
  EXPECT_NEAR(converted(std::numbers::pi, "rad", "deg"), 180, 1e-13);
  EXPECT_NEAR(converted(1, "arcsec", "rad"), kRadPerArcsec, 1e-21);
  EXPECT_NEAR(converted(1, "mrad", "arcsec"), 206.26480624709635, 1e-11);
}

TEST(UnitConversion, SaysHowFarTheDecimalPointMoves) {
  EXPECT_EQ(unit_conversion("m", "mm")->decimal_shift(), 3);
  EXPECT_EQ(unit_conversion("nm", "mm")->decimal_shift(), -6);
  EXPECT_EQ(unit_conversion("mm", "mm")->decimal_shift(), 0);
  EXPECT_EQ(unit_conversion("mbar", "hPa")->decimal_shift(), 0);
  EXPECT_FALSE(unit_conversion("deg", "arcsec")->decimal_shift());
  EXPECT_FALSE(unit_conversion("K", "degC")->decimal_shift());
}

TEST(UnitConversion, GoesThereAndBackBetweenAllUnitsOfAKind) {
  int pairs = 0;
  for (const auto& from : known_units())
    for (const auto& to : known_units()) {
      const auto there = unit_conversion(from, to), back = unit_conversion(to, from);
      ASSERT_EQ(there.has_value(), back.has_value());
      if (!there) {
        EXPECT_EQ(there.error().reason, "UNIT_KIND") << from << " -> " << to;
        continue;
      }
      ++pairs;
      EXPECT_NEAR((*back)((*there)(12.375)), 12.375, 1e-12) << from << " -> " << to;
    }
  EXPECT_EQ(pairs,
            16 + 9 + 4 + 1 + 4 + 4 + 1 + 1 + 1 + 4 + 1);  // lengths, angles, temperatures, ...
}

TEST(UnitConversion, RefusesOtherKindsAndUnknownUnits) {
  EXPECT_EQ(unit_conversion("mm", "degC").error().reason, "UNIT_KIND");
  EXPECT_EQ(unit_conversion("furlong", "m").error().reason, "UNKNOWN_UNIT");
  EXPECT_EQ(unit_conversion("m", "").error().reason, "UNKNOWN_UNIT");
}

}  // namespace
}  // namespace driftwise
