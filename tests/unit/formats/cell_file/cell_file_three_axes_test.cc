// What a cell with several lengths, tilts and a force says in its file: autocollimators, the
// correction from raw readings to pose, the load.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "drivers/all_devices.h"
#include "server/formats/cell_file/cell_file.h"

namespace driftwise::formats {
namespace {

const std::string kThreeAxes = R"([cell]
name = "three-axes"
database = "cell.db"

[[device]]
id = "laser-x"
kind = "interferometer-adapter"
address = "127.0.0.1:50010"
length = "x_mm"

[[device]]
id = "laser-z"
kind = "interferometer-adapter"
address = "127.0.0.1:50011"
length = "z_mm"

[[device]]
id = "collimator-1"
kind = "newport-lds1000"
address = "127.0.0.1:50020"
options = { unit = "sec" }
  [[device.angle]]
  channel = "ry_arcsec"
  device_axis = 1
  sign = -1
  u_arcsec = 0.02
  [[device.angle]]
  channel = "rz_arcsec"
  device_axis = 2

[[device]]
id = "collimator-2"
kind = "newport-lds1000"
address = "127.0.0.1:50021"
  [[device.angle]]
  channel = "rx_arcsec"
  device_axis = 1

[[device]]
id = "load"
kind = "load-actuator"
address = "127.0.0.1:50030"
channel = "force_N"

[load]
max_n = 4
u_n = 0.002
gravity_m_s2 = 9.81

[correction]
cosine = true
  [[correction.beam]]
  length = "z_mm"
  offset_mm = [0.4, -1.2, 12]
  offset_per_mm = [-1, -1, 0]
  u_offset_mm = 0.3
  direction_arcsec = [4, 0, 0]
  u_direction_arcsec = 2
  u_flatness_nm = 10
)";

TEST(ParseCellFileOfThreeAxes, ReadsAutocollimatorsCorrectionAndLoad) {
  const auto cell = parse_cell_file(kThreeAxes, "cell.toml", drivers::all_devices());
  ASSERT_TRUE(cell) << cell.error().message;
  const auto& angles = cell->find_device("collimator-1")->angles();
  ASSERT_EQ(angles.size(), 2u);
  EXPECT_EQ(angles[0].channel.name(), "ry_arcsec");
  EXPECT_EQ(angles[0].device_axis, 1);
  EXPECT_EQ(angles[0].sign, -1);
  EXPECT_EQ(angles[0].u_arcsec, 0.02);
  EXPECT_EQ(angles[1].sign, 1);
  EXPECT_EQ(cell->angle_channels().size(), 3u);

  ASSERT_TRUE(cell->correction);
  EXPECT_TRUE(cell->correction->cosine);
  ASSERT_EQ(cell->correction->beams.size(), 1u);
  const auto& beam = cell->correction->beams[0];
  EXPECT_EQ(beam.length.name(), "z_mm");
  EXPECT_EQ(beam.offset_mm, (std::array<double, 3>{0.4, -1.2, 12}));
  EXPECT_EQ(beam.offset_per_mm, (std::array<double, 3>{-1, -1, 0}));
  EXPECT_EQ(beam.u_offset_mm, 0.3);
  EXPECT_EQ(beam.direction_arcsec, (std::array<double, 3>{4, 0, 0}));
  EXPECT_EQ(beam.u_direction_arcsec, 2);
  EXPECT_EQ(beam.u_flatness_nm, 10);

  ASSERT_TRUE(cell->load);
  EXPECT_EQ(cell->load->max_n, 4);
  EXPECT_EQ(cell->load->gravity_m_s2, 9.81);
  EXPECT_EQ(cell->load_actuator()->id, "load");
  EXPECT_EQ(cell->force_channel()->name(), "force_N");
}

TEST(ParseCellFileOfThreeAxes, NamesTheRawPathsBesideTheCorrectedPose) {
  auto cell = parse_cell_file(kThreeAxes, "cell.toml", drivers::all_devices());
  ASSERT_TRUE(cell);
  EXPECT_EQ(cell->length_channels()[1].name(), "z_mm");
  EXPECT_EQ(cell->path_channels()[1].name(), "z_path_mm");
  cell->correction.reset();
  EXPECT_EQ(cell->path_channels()[1].name(), "z_mm");
}

TEST(ParseCellFileOfThreeAxes, KnowsALoadThatAPersonChanges) {
  std::string text = kThreeAxes;
  const auto from = text.find("[[device]]\nid = \"load\"");
  text.erase(from, text.find("[load]") - from);
  const auto cell = parse_cell_file(text, "cell.toml", drivers::all_devices());
  ASSERT_TRUE(cell) << cell.error().message;
  EXPECT_EQ(cell->load_actuator(), nullptr);
  EXPECT_EQ(cell->force_channel()->name(), "force_N");
}

TEST(ParseCellFileOfThreeAxes, ReadsTheMicroNano) {
  const auto cell =
      read_cell_file(std::string(DRIFTWISE_SOURCE_DIR) + "/deploy/cells/micro-nano/cell.toml",
                     drivers::all_devices());
  ASSERT_TRUE(cell) << cell.error().message;
  EXPECT_EQ(cell->motor_channels().size(), 3u);
  EXPECT_EQ(cell->path_channels().size(), 3u);
  EXPECT_EQ(cell->angle_channels().size(), 3u);
  EXPECT_EQ(cell->temperature_channels().size(), 10u);
  EXPECT_EQ(cell->run.max_spread_nm, 20);
}

struct ThreeAxesMistake {
  const char* name;
  const char* from;
  const char* to;
  const char* reason;
  const char* says;
};
class BadThreeAxes : public testing::TestWithParam<ThreeAxesMistake> {};
TEST_P(BadThreeAxes, AreRefusedWithFileLineFieldFoundAndExpected) {
  std::string text = kThreeAxes;
  const auto at = text.find(GetParam().from);
  ASSERT_NE(at, std::string::npos);
  text.replace(at, std::string_view(GetParam().from).size(), GetParam().to);
  const auto cell = parse_cell_file(text, "cell.toml", drivers::all_devices());
  ASSERT_FALSE(cell);
  EXPECT_EQ(cell.error().reason, GetParam().reason) << cell.error().message;
  EXPECT_NE(cell.error().message.find(GetParam().says), std::string::npos) << cell.error().message;
}
INSTANTIATE_TEST_SUITE_P(
    Table, BadThreeAxes,
    testing::Values(
        ThreeAxesMistake{"NearestKeyOfAnAngle", "u_arcsec", "u_arcsecs", "UNKNOWN_KEY",
                         "cell.toml:26: device 3, angle 1: found the unknown key 'u_arcsecs': did "
                         "you mean u_arcsec?"},
        ThreeAxesMistake{"NearestKeyOfABeam", "offset_per_mm", "offset_pr_mm", "UNKNOWN_KEY",
                         "correction, beam 1: found the unknown key 'offset_pr_mm': did you mean "
                         "offset_per_mm?"},
        ThreeAxesMistake{"NearestKeyOfTheLoad", "gravity_m_s2", "gravity_ms2", "UNKNOWN_KEY",
                         "load: found the unknown key 'gravity_ms2': did you mean gravity_m_s2?"},
        ThreeAxesMistake{"NearestSection", "[correction]", "[corection]", "UNKNOWN_KEY",
                         "'corection': did you mean correction?"},
        ThreeAxesMistake{"AngleInRadians", "ry_arcsec", "ry_rad", "BAD_CHANNEL",
                         "found 'ry_rad', expected a rotation: rx_arcsec"},
        ThreeAxesMistake{"AngleThatIsALength", "ry_arcsec", "y_mm", "BAD_CHANNEL",
                         "expected a rotation"},
        ThreeAxesMistake{"AngleTwice", "rz_arcsec", "ry_arcsec", "DUPLICATE_CHANNEL",
                         "device 3, angle 2: channel: found 'ry_arcsec'"},
        ThreeAxesMistake{"DeviceAxisTwice", "device_axis = 2", "device_axis = 1",
                         "DUPLICATE_CHANNEL",
                         "device 3, angle 2: device_axis: found device axis 1"},
        ThreeAxesMistake{"ThirdDeviceAxis", "device_axis = 2", "device_axis = 3", "OUT_OF_RANGE",
                         "found 3, expected a whole number from 1 to 2"},
        ThreeAxesMistake{"NoSign", "sign = -1", "sign = 0", "OUT_OF_RANGE",
                         "found 0, expected 1 or -1"},
        ThreeAxesMistake{"ForceInGrams", "\"force_N\"", "\"force_g\"", "BAD_CHANNEL",
                         "'force_g' is no channel"},
        ThreeAxesMistake{"ActuatorWithoutLoad",
                         "[load]\nmax_n = 4\nu_n = 0.002\ngravity_m_s2 = 9.81\n", "", "MISSING_KEY",
                         "found no [load] section beside the load actuator 'load'"},
        ThreeAxesMistake{"NoLargestForce", "max_n = 4\n", "", "MISSING_KEY", "load: max_n"},
        ThreeAxesMistake{"BeamOfNoLength", "length = \"z_mm\"\n  offset",
                         "length = \"y_mm\"\n  offset", "BAD_CHANNEL",
                         "found 'y_mm', which no interferometer of this cell gives; its lengths "
                         "are x_mm, z_mm"},
        ThreeAxesMistake{"TwoNumbers", "[0.4, -1.2, 12]", "[0.4, -1.2]", "WRONG_TYPE",
                         "offset_mm: found an array, expected three numbers"},
        ThreeAxesMistake{"NoNumber", "[0.4, -1.2, 12]", "[0.4, \"a\", 12]", "WRONG_TYPE",
                         "expected a number in each of the three places"},
        ThreeAxesMistake{"NotFinite", "[0.4, -1.2, 12]", "[0.4, nan, 12]", "OUT_OF_RANGE",
                         "found not a number, expected a number from -10000 to 10000"},
        ThreeAxesMistake{"TiltThatNobodyMeasures", "rz_arcsec", "rx_arcsec", "DUPLICATE_CHANNEL",
                         "found 'rx_arcsec'"},
        ThreeAxesMistake{"CosineWithoutTilt",
                         "  [[device.angle]]\n  channel = \"rz_arcsec\"\n  device_axis = 2\n", "",
                         "MISSING_KEY", "the correction of 'x_mm' needs rz_arcsec"}),
    [](const auto& row) { return std::string(row.param.name); });

}  // namespace
}  // namespace driftwise::formats
