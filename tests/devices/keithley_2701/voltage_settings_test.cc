// [[device]] of kind keithley-2701 that measures voltages: what is read, and what is refused.

#include <gmock/gmock.h>

#include <cmath>

#include "drivers/all_devices.h"
#include "server/formats/cell_file/cell_file.h"

namespace driftwise {
namespace {

using testing::HasSubstr;

constexpr const char* kAxisOfCell =
    "[cell]\nname = \"c\"\ndatabase = \"d\"\n[[device]]\nid = \"axis\"\nkind = \"pi-gcs\"\n"
    "address = \"127.0.0.1:1\"\n  [[device.axis]]\n  channel = \"q1_mm\"\n  device_axis = \"X\"\n"
    "  min_mm = -5\n  max_mm = 5\n";

Result<CellDescription> cell_with_sensors(const std::string& keys, const std::string& rest = "") {
  return formats::parse_cell_file(std::string(kAxisOfCell) +
                                      "[[device]]\nid = \"level\"\nkind = \"keithley-2701\"\n"
                                      "address = \"127.0.0.1:1394\"\n" +
                                      keys + rest,
                                  "cell.toml", drivers::all_devices());
}

std::string sensor(const std::string& keys) {
  return "  [[device.sensor]]\n  input = 201\n  min_v = -5\n  max_v = 5\n" + keys;
}

TEST(VoltageSettings, OfAnInclinometerMakeADeviceForAngles) {
  const auto cell =
      cell_with_sensors("measures = \"angle\"\n" +
                        sensor("channel = \"rx_arcsec\"\ncurve = \"arcsine\"\nslope = 0.0684\n"
                               "slope_unit = \"1/V\"\nzero_v = 0.012\nu = 36\n"));
  ASSERT_TRUE(cell) << cell.error().message;
  const auto& level = cell->devices[1];
  EXPECT_EQ(level.role(), DeviceRole::angle);
  ASSERT_EQ(level.angles().size(), 1u);
  EXPECT_EQ(level.angles()[0].channel, (Channel{"rx", "arcsec"}));
  EXPECT_EQ(level.angles()[0].u_arcsec, 36);
  EXPECT_EQ(level.channels, (std::vector<Channel>{{"rx", "arcsec"}, {"level_201", "V"}}));
}

TEST(VoltageSettings, TakeASlopeInAnyUnitOfTheQuantity) {
  const auto cell =
      cell_with_sensors("measures = \"length\"\n" + sensor("channel = \"z_mm\"\nslope = 2\n"
                                                           "slope_unit = \"um/mV\"\n"));
  ASSERT_TRUE(cell) << cell.error().message;
  EXPECT_DOUBLE_EQ(cell->devices[1].voltages.sensors[0].slope, 2) << "2 um/mV is 2 mm/V";
  const auto angle =
      cell_with_sensors("measures = \"angle\"\n" + sensor("channel = \"rx_arcsec\"\nslope = 4\n"
                                                          "slope_unit = \"deg/V\"\n"));
  ASSERT_TRUE(angle) << angle.error().message;
  EXPECT_DOUBLE_EQ(angle->devices[1].voltages.sensors[0].slope, 14400);
}

std::string plate_of(const std::string& y3) {
  std::string text =
      "measures = \"plate\"\nlength = \"z_mm\"\ntilt_x = \"rx_arcsec\"\n"
      "tilt_y = \"ry_arcsec\"\n";
  int input = 201;
  for (const std::string& place :
       {std::string("40\n  y_mm = 0"), std::string("-20\n  y_mm = 35"), "-20\n  y_mm = " + y3})
    text += "  [[device.sensor]]\n  input = " + std::to_string(input++) +
            "\n  min_v = 0.5\n  max_v = 9.5\n  slope = 1\n  slope_unit = \"mm/V\"\n  u = 0.0003\n"
            "  x_mm = " +
            place + "\n";
  return text;
}

TEST(VoltageSettings, OfAPlateMakeALengthWithTwoRotations) {
  const auto cell = cell_with_sensors(plate_of("-35"));
  ASSERT_TRUE(cell) << cell.error().message;
  const auto& plate = cell->devices[1];
  EXPECT_EQ(plate.role(), DeviceRole::length);
  EXPECT_EQ(plate.length()->channel, (Channel{"z", "mm"}));
  EXPECT_NEAR(plate.length()->u_length_nm, 300 / std::sqrt(3.0), 1e-6);
  ASSERT_EQ(plate.angles().size(), 2u);
  EXPECT_NEAR(plate.angles()[0].u_arcsec, 1.25, 0.005);
  EXPECT_EQ(cell->angle_channels(), (std::vector<Channel>{{"rx", "arcsec"}, {"ry", "arcsec"}}));
}

TEST(VoltageSettings, OfAMotorGiveItsForceItsUncertaintyAndItsDeadBand) {
  const auto cell = cell_with_sensors(
      "period_s = 1\nmeasures = \"motor-force\"\naxis = \"q1_mm\"\nfriction_n = 0.3\n"
      "u_friction_n = 0.02\ntravel_mm = 0.01\n" +
      sensor("channel = \"force_N\"\nslope = 2\nslope_unit = \"N/V\"\nu = 0.01\n"));
  ASSERT_TRUE(cell) << cell.error().message;
  EXPECT_EQ(cell->devices[1].role(), DeviceRole::force);
  EXPECT_EQ(cell->devices[1].channels,
            (std::vector<Channel>{
                {"force", "N"}, {"level_201", "V"}, {"force_u", "N"}, {"force_dead_band", "1"}}));
}

struct BadSensor {
  const char* name;
  std::string keys;
  const char* reason;
  const char* message;
};
class BadSensors : public testing::TestWithParam<BadSensor> {};
TEST_P(BadSensors, AreRefusedWithTheirPlace) {
  const auto cell = cell_with_sensors(GetParam().keys);
  ASSERT_FALSE(cell);
  EXPECT_EQ(cell.error().reason, GetParam().reason) << cell.error().message;
  EXPECT_THAT(cell.error().message, HasSubstr(GetParam().message));
  EXPECT_THAT(cell.error().message, HasSubstr("cell.toml:"));
}
const std::string kForce = "channel = \"force_N\"\nslope = 2\nslope_unit = \"N/V\"\n";
INSTANTIATE_TEST_SUITE_P(
    Table, BadSensors,
    testing::Values(
        BadSensor{"measures", "measures = \"weight\"\n", "OUT_OF_RANGE", "motor-force"},
        BadSensor{"none", "measures = \"force\"\n", "MISSING_KEY", "[[device.sensor]]"},
        BadSensor{"channel", "measures = \"angle\"\n" + sensor(kForce), "BAD_CHANNEL",
                  "found 'force_N', expected a rotation in arcsec such as rx_arcsec"},
        BadSensor{"unit",
                  "measures = \"force\"\n" +
                      sensor("channel = \"force_N\"\nslope = 2\nslope_unit = \"mm/V\"\n"),
                  "BAD_UNIT", "found 'mm/V', expected a unit of force_N per volt, such as N/V"},
        BadSensor{"no_ratio",
                  "measures = \"force\"\n" +
                      sensor("channel = \"force_N\"\nslope = 2\nslope_unit = \"N\"\n"),
                  "BAD_UNIT", "found 'N'"},
        BadSensor{"arcsine_unit",
                  "measures = \"angle\"\n" +
                      sensor("channel = \"rx_arcsec\"\ncurve = \"arcsine\"\nslope = 4\n"
                             "slope_unit = \"deg/V\"\n"),
                  "BAD_UNIT", "an arcsine's slope is the sine per volt"},
        BadSensor{"no_sine",
                  "measures = \"angle\"\n" +
                      sensor("channel = \"rx_arcsec\"\ncurve = \"arcsine\"\nslope = 0.3\n"
                             "slope_unit = \"1/V\"\n"),
                  "BAD_VALUE", "expected at most 1"},
        BadSensor{"arcsine_force",
                  "measures = \"force\"\n" + sensor("curve = \"arcsine\"\n" + kForce), "BAD_VALUE",
                  "only an angle is an arcsine"},
        BadSensor{"range",
                  "measures = \"force\"\n  [[device.sensor]]\n  input = 201\n"
                  "  min_v = 5\n  max_v = -5\n" +
                      kForce,
                  "BAD_LIMITS", "expected min_v below max_v"},
        BadSensor{"twice",
                  "measures = \"force\"\n" + sensor(kForce) +
                      sensor("channel = \"push_N\"\nslope = 2\nslope_unit = \"N/V\"\n"),
                  "DUPLICATE_CHANNEL", "found input 201"},
        BadSensor{"line", plate_of("35"), "BAD_VALUE", "expected a triangle"},
        BadSensor{"two_lengths",
                  "measures = \"length\"\n" +
                      sensor("channel = \"z_mm\"\nslope = 2\nslope_unit = \"mm/V\"\n") +
                      "  [[device.sensor]]\n  input = 202\n  min_v = -5\n  max_v = 5\n"
                      "channel = \"x_mm\"\nslope = 2\nslope_unit = \"mm/V\"\n",
                  "BAD_VALUE", "found 2 sensors, expected 1"},
        BadSensor{"axis",
                  "measures = \"motor-force\"\naxis = \"q7_mm\"\nfriction_n = 0.3\n"
                  "travel_mm = 0.01\n" +
                      sensor(kForce),
                  "BAD_CHANNEL", "found 'q7_mm', which no controller of this cell moves"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(VoltageSettings, LeaveTheForceThatHangsToTheLoad) {
  const auto cell =
      cell_with_sensors("measures = \"force\"\n" + sensor(kForce), "[load]\nmax_n = 3\n");
  ASSERT_FALSE(cell);
  EXPECT_EQ(cell.error().reason, "DUPLICATE_CHANNEL");
  EXPECT_THAT(cell.error().message, HasSubstr("measured_force_N"));
}

}  // namespace
}  // namespace driftwise
