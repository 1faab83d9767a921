#include "server/formats/cell_file/kinematics_section.h"

#include <gtest/gtest.h>

#include "drivers/all_devices.h"
#include "server/formats/cell_file/cell_file.h"

namespace driftwise::formats {
namespace {

const std::string kDelta = R"([kinematics]
kind = "delta-vertical"
carriages = "below"
hold = ["frame.*", "*.scale_ppm"]

[kinematics.frame]
rz_deg = 1.5

[[kinematics.branch]]
motor = "q1_mm"
azimuth_deg = 90
radius_mm = 30
length_mm = 50
tilt_radial_deg = 0.25

[[kinematics.branch]]
motor = "q2_mm"
azimuth_deg = 210
radius_mm = 30.5
length_mm = 50
offset_mm = -0.5

[[kinematics.branch]]
motor = "q3_mm"
azimuth_deg = 330
radius_mm = 30
length_mm = 50
scale_ppm = 100
)";

const std::string kArm = R"([kinematics]
kind = "serial-arm"
tool_z_mm = 109

[[kinematics.link]]
motor = "q1_rad"
d_mm = 127.3
a_mm = 0
alpha_deg = 90

[[kinematics.link]]
motor = "q2_rad"
d_mm = 0
a_mm = -612
alpha_deg = 0
theta_deg = 10
beta_deg = -0.1
)";

TEST(RobotFile, DescribesADelta) {
  const auto robot = parse_robot_file(kDelta, "robot.toml");
  ASSERT_TRUE(robot) << robot.error().message;
  EXPECT_EQ(robot->kind, "delta-vertical");
  EXPECT_FALSE(robot->carriages_above);
  ASSERT_EQ(robot->branches.size(), 3U);
  EXPECT_EQ(robot->branches[1].motor.name(), "q2_mm");
  EXPECT_EQ(robot->branches[1].radius_mm, 30.5);
  EXPECT_EQ(robot->branches[1].offset_mm, -0.5);
  EXPECT_EQ(robot->branches[0].tilt_radial_deg, 0.25);
  EXPECT_EQ(robot->frame.rz_deg, 1.5);
  EXPECT_EQ(robot->hold, (std::vector<std::string>{"frame.*", "*.scale_ppm"}));
}

TEST(RobotFile, DescribesASerialArm) {
  const auto robot = parse_robot_file(kArm, "robot.toml");
  ASSERT_TRUE(robot) << robot.error().message;
  ASSERT_EQ(robot->links.size(), 2U);
  EXPECT_EQ(robot->links[1].a_mm, -612);
  EXPECT_EQ(robot->links[1].theta_deg, 10);
  EXPECT_EQ(robot->links[1].beta_deg, -0.1);
  EXPECT_EQ(robot->tool_z_mm, 109);
}

TEST(RobotFile, IsWrittenAsItIsRead) {
  for (const auto& text : {kDelta, kArm}) {
    const auto robot = parse_robot_file(text, "robot.toml");
    const std::string written = write_robot_file(*robot);
    const auto again = parse_robot_file(written, "written.toml");
    ASSERT_TRUE(again) << again.error().message << '\n' << written;
    EXPECT_EQ(write_robot_file(*again), written);
    EXPECT_EQ(again->hold, robot->hold);
    EXPECT_EQ(again->frame.rz_deg, robot->frame.rz_deg);
  }
}

TEST(RobotFile, MayBeAWholeCell) {
  const std::string cell = "[cell]\nname = \"m\"\ndatabase = \"m.db\"\n" + kDelta +
                           "\n[[device]]\nid = \"a\"\nkind = \"pi-gcs\"\naddress = "
                           "\"127.0.0.1:1\"\n[[device.axis]]\nchannel = \"q1_mm\"\ndevice_axis = "
                           "\"X\"\nmin_mm = -1\nmax_mm = 1\n";
  const auto robot = parse_robot_file(cell, "cell.toml");
  ASSERT_TRUE(robot) << robot.error().message;
  const auto description = parse_cell_file(cell, "cell.toml", drivers::all_devices());
  ASSERT_TRUE(description) << description.error().message;
  ASSERT_TRUE(description->kinematics);
  EXPECT_EQ(write_robot_file(*description->kinematics), write_robot_file(*robot));
}

TEST(CellFile, NeedsNoKinematics) {
  const auto cell = parse_cell_file(
      "[cell]\nname = \"m\"\ndatabase = \"m.db\"\n[[device]]\nid = \"a\"\nkind = "
      "\"watlow-ez-zone\"\naddress = \"127.0.0.1:1\"\n",
      "cell.toml", drivers::all_devices());
  ASSERT_TRUE(cell) << cell.error().message;
  EXPECT_FALSE(cell->kinematics);
}

struct RobotFileMistake {
  const char* name;
  std::string text;
  const char *from, *to, *reason, *sentence;
};

class RobotFileMistakes : public testing::TestWithParam<RobotFileMistake> {};

TEST_P(RobotFileMistakes, AreNamedWithFileAndLine) {
  std::string text = GetParam().text;
  const auto at = text.find(GetParam().from);
  ASSERT_NE(at, std::string::npos);
  text.replace(at, std::string(GetParam().from).size(), GetParam().to);
  const auto robot = parse_robot_file(text, "robot.toml");
  ASSERT_FALSE(robot);
  EXPECT_EQ(robot.error().reason, GetParam().reason) << robot.error().message;
  EXPECT_NE(robot.error().message.find(GetParam().sentence), std::string::npos)
      << robot.error().message;
  EXPECT_TRUE(robot.error().message.starts_with("robot.toml:")) << robot.error().message;
}

INSTANTIATE_TEST_SUITE_P(
    Table, RobotFileMistakes,
    testing::Values(
        RobotFileMistake{"Syntax", kDelta, "= 90", "= ninety", "TOML_SYNTAX", "robot.toml:11: "},
        RobotFileMistake{"NoSection", "[robot]\n", "robot", "dynamics", "NO_KINEMATICS",
                         "found no [kinematics] section"},
        RobotFileMistake{"Kind", kDelta, "\"delta-vertical\"", "\"hexapod\"", "UNKNOWN_KIND",
                         "robot.toml:2: kinematics: kind: found 'hexapod'"},
        RobotFileMistake{"Key", kDelta, "radius_mm = 30.5", "radius = 30.5", "MISSING_KEY",
                         "kinematics, branch 2: radius_mm: found 'radius', expected this key"},
        RobotFileMistake{"ExtraKey", kDelta, "offset_mm", "ofset_mm", "UNKNOWN_KEY",
                         "did you mean offset_mm?"},
        RobotFileMistake{"Negative", kDelta, "length_mm = 50", "length_mm = -50", "OUT_OF_RANGE",
                         "found -50, expected a finite number above 0"},
        RobotFileMistake{"ShortArm", kDelta, "length_mm = 50", "length_mm = 20", "BAD_KINEMATICS",
                         "0 < radius_mm < length_mm"},
        RobotFileMistake{"Motor", kDelta, "\"q1_mm\"", "\"x_mm\"", "BAD_CHANNEL",
                         "expected a motor coordinate such as q1_mm"},
        RobotFileMistake{"MotorTwice", kDelta, "\"q1_mm\"", "\"q2_mm\"", "BAD_KINEMATICS",
                         "found q2_mm twice"},
        RobotFileMistake{"Hold", kDelta, "\"frame.*\"", "\"base.*\"", "UNKNOWN_PARAMETER",
                         "names no parameter of this robot; it has: branch1.radius_mm"},
        RobotFileMistake{"HoldType", kDelta, "\"frame.*\", ", "3, ", "WRONG_TYPE",
                         "hold: found 3, expected a list of strings"},
        RobotFileMistake{"JointUnit", kArm, "\"q2_rad\"", "\"q2_mm\"", "BAD_KINEMATICS",
                         "expected a joint angle in rad or deg"},
        RobotFileMistake{"ToolOfADelta", kDelta, "carriages", "tool_x_mm = 1\ncarriages",
                         "UNKNOWN_KEY", "tool_x_mm"}),
    [](const auto& row) { return std::string(row.param.name); });

}  // namespace
}  // namespace driftwise::formats
