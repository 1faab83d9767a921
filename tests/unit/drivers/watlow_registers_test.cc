#include <gtest/gtest.h>

#include <cmath>

#include "drivers/watlow_ez_zone/registers.h"
#include "drivers/watlow_ez_zone/watlow_options.h"

namespace driftwise::watlow {
namespace {

TEST(WatlowFloat, IsPackedAsTheManualSays) {
  // 75.0 -> 2160 = 0x0000, 2161 = 0x4296 (EZ-ZONE PM user's guide).
  EXPECT_EQ(pack_float(75.0f, WordOrder::low_first),
            (std::array<std::uint16_t, 2>{0x0000, 0x4296}));
  EXPECT_EQ(pack_float(75.0f, WordOrder::high_first),
            (std::array<std::uint16_t, 2>{0x4296, 0x0000}));
  // 71.6 = 0x428f3333, which libmodbus 3.1.6 packs wrongly.
  EXPECT_EQ(pack_float(71.6f, WordOrder::high_first),
            (std::array<std::uint16_t, 2>{0x428f, 0x3333}));
}

TEST(WatlowFloat, ReadsBackInBothOrders) {
  for (const float value : {0.0f, -0.0f, 68.36f, -40.0f, 1e-30f, 3.4e38f}) {
    for (const auto order : {WordOrder::low_first, WordOrder::high_first})
      EXPECT_EQ(unpack_float(pack_float(value, order), order), value);
  }
}

TEST(WatlowTemperature, IsConvertedAtTheEdge) {
  EXPECT_NEAR(degc_from_wire(68.0f, Unit::fahrenheit), 20.0, 1e-9);
  EXPECT_EQ(degc_from_wire(20.0f, Unit::celsius), 20.0);
  EXPECT_FLOAT_EQ(wire_from_degc(21.0, Unit::fahrenheit), 69.8f);
}

// A difference has no offset: 3.6 F are 2 K.
TEST(WatlowTemperature, OfABandIsADifference) {
  EXPECT_NEAR(kelvin_from_wire(3.6f, Unit::fahrenheit), 2.0, 1e-6);
  EXPECT_EQ(kelvin_from_wire(2.0f, Unit::celsius), 2.0);
  EXPECT_FLOAT_EQ(wire_from_kelvin(2.0, Unit::fahrenheit), 3.6f);
}

TEST(WatlowPlausibility, CatchesAWrongUnitAndAWrongWordOrder) {
  EXPECT_TRUE(is_plausible(20.5));
  EXPECT_FALSE(
      is_plausible(degc_from_wire(wire_from_degc(20.5, Unit::fahrenheit), Unit::celsius)));  // 68.9
  EXPECT_FALSE(
      is_plausible(degc_from_wire(wire_from_degc(20.5, Unit::celsius), Unit::fahrenheit)));  // -6.4
  const auto registers = pack_float(wire_from_degc(20.5, Unit::fahrenheit), WordOrder::low_first);
  EXPECT_FALSE(is_plausible(
      degc_from_wire(unpack_float(registers, WordOrder::high_first), Unit::fahrenheit)));
  EXPECT_FALSE(is_plausible(std::nan("")));
}

TEST(WatlowNames, AreMadeFromTheDeviceId) { EXPECT_EQ(symbol_from_id("laser-base"), "laser_base"); }

TEST(WatlowOptions, AreCheckedByNameAndValue) {
  DeviceDescription device;
  device.id = "support";
  device.options = {{"unit", "C"}, {"word_order", "high_first"}, {"zone", "2"}, {"unit_id", "7"}};
  const auto options = read_options(device);
  ASSERT_TRUE(options);
  EXPECT_EQ(options->unit, Unit::celsius);
  EXPECT_EQ(options->word_order, WordOrder::high_first);
  EXPECT_EQ(options->unit_id, 7);
  device.options = {{"heat_band_k", "2"}, {"integral_s", "180"}};
  const auto declared = read_options(device)->declared;
  EXPECT_EQ(declared.heat_band_k, 2);
  EXPECT_EQ(declared.integral_s, 180);
  EXPECT_FALSE(declared.cool_band_k);
  device.options = {{"unit", "K"}};
  EXPECT_EQ(read_options(device).error().reason, "BAD_OPTION");
  device.options = {{"wordorder", "low_first"}};
  EXPECT_EQ(read_options(device).error().reason, "BAD_OPTION");
}

}  // namespace
}  // namespace driftwise::watlow
