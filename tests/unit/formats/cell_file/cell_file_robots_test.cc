// [[robot]] of a cell file.

#include <gmock/gmock.h>

#include "drivers/all_devices.h"
#include "server/formats/cell_file/cell_file.h"
#include "server/formats/cell_file/cell_file_difference.h"

namespace driftwise::formats {
namespace {

using testing::HasSubstr;

std::string controller_text(const std::string& id, const std::vector<std::string>& axes) {
  std::string text =
      "[[device]]\nid = \"" + id + "\"\nkind = \"pi-gcs\"\naddress = \"127.0.0.1:1\"\n";
  int number = 0;
  for (const auto& axis : axes)
    text += "[[device.axis]]\nchannel = \"" + axis + "\"\ndevice_axis = \"" +
            std::to_string(++number) + "\"\nmin_mm = -1\nmax_mm = 1\n";
  return text;
}

const std::string kHead = "[cell]\nname = \"two\"\ndatabase = \"two.db\"\n";
const std::string kTwoRobots =
    "[[robot]]\nid = \"ma\"\ncontroller = \"gantry\"\ntool = \"probe-3\"\n"
    "[[robot]]\nid = \"mn\"\ncontroller = \"hexapod\"\naxes = [\"mn.q1_mm\"]\n";
const std::string kTwoControllers =
    controller_text("gantry", {"ma.q1_mm", "ma.q2_mm"}) + controller_text("hexapod", {"mn.q1_mm"}) +
    "[[device]]\nid = \"laser\"\nkind = \"interferometer-adapter\"\n"
    "address = \"127.0.0.1:2\"\nlength = \"ma.x_mm\"\n";

Result<CellDescription> read(const std::string& text) {
  return parse_cell_file(text, "cell.toml", drivers::all_devices());
}

TEST(CellFileRobots, AFileWithoutRobotsHasOne) {
  const auto cell = read(kHead + controller_text("axis", {"q1_mm", "q2_mm"}));
  ASSERT_TRUE(cell) << cell.error().message;
  ASSERT_EQ(cell->robots.size(), 1U);
  EXPECT_EQ(cell->robots[0].id, "");
  EXPECT_EQ(cell->robots[0].controller, "axis");
  EXPECT_EQ(cell->robots[0].axes, (std::vector<Channel>{{"q1", "mm"}, {"q2", "mm"}}));
}

TEST(CellFileRobots, OneWithAnIdKeepsPlainNames) {
  const auto cell = read(kHead + "[[robot]]\nid = \"ma\"\n" + controller_text("axis", {"q1_mm"}));
  ASSERT_TRUE(cell) << cell.error().message;
  EXPECT_EQ(cell->robots[0].id, "ma");
  EXPECT_EQ(cell->robots[0].controller, "axis");
  EXPECT_EQ(cell->motor_channels().front().name(), "q1_mm");
}

TEST(CellFileRobots, SeveralCarryTheirIdInTheChannels) {
  const auto cell = read(kHead + kTwoRobots + kTwoControllers);
  ASSERT_TRUE(cell) << cell.error().message;
  ASSERT_EQ(cell->robots.size(), 2U);
  EXPECT_EQ(cell->robots[0].tool, "probe-3");
  EXPECT_EQ(cell->robots[0].axes, (std::vector<Channel>{{"ma.q1", "mm"}, {"ma.q2", "mm"}}));
  EXPECT_EQ(cell->robots[1].axes, (std::vector<Channel>{{"mn.q1", "mm"}}));
  EXPECT_EQ(cell->length_channels().front().name(), "ma.x_mm");
}

TEST(CellFileRobots, ShareAControllerByTheNamesOfItsAxes) {
  const auto cell = read(kHead + "[[robot]]\nid = \"ma\"\n[[robot]]\nid = \"mn\"\n" +
                         controller_text("gantry", {"ma.q1_mm", "mn.q1_mm", "mn.q2_mm"}));
  ASSERT_TRUE(cell) << cell.error().message;
  EXPECT_EQ(cell->robots[0].axes, (std::vector<Channel>{{"ma.q1", "mm"}}));
  EXPECT_EQ(cell->robots[1].axes, (std::vector<Channel>{{"mn.q1", "mm"}, {"mn.q2", "mm"}}));
}

std::string keep_out_text(const std::string& first_axis, const std::string& second_axis,
                          const std::string& per_mm = "-1", const std::string& at_zero = "6") {
  std::string text = "[[keep_out]]\nname = \"tips\"\nmin_mm = 1\nat_zero_mm = " + at_zero + "\n";
  for (const auto& axis : {first_axis, second_axis})
    text += "[[keep_out.axis]]\nchannel = \"" + axis + "\"\nper_mm = " + per_mm + "\n";
  return text;
}

TEST(CellFileRobots, KeepADistance) {
  const auto cell =
      read(kHead + kTwoRobots + kTwoControllers + keep_out_text("ma.q2_mm", "mn.q1_mm"));
  ASSERT_TRUE(cell) << cell.error().message;
  ASSERT_EQ(cell->keep_outs.size(), 1U);
  EXPECT_EQ(cell->keep_outs[0].robots, (std::vector<std::string>{"ma", "mn"}));
  EXPECT_EQ(cell->keep_outs[0].terms[1].axis.name(), "mn.q1_mm");
}

struct RobotMistake {
  const char* name;
  std::string text;
  const char* reason;
  const char* message;
};
class CellFileRobot : public testing::TestWithParam<RobotMistake> {};
TEST_P(CellFileRobot, IsRefusedByName) {
  const auto cell = read(GetParam().text);
  ASSERT_FALSE(cell);
  EXPECT_EQ(cell.error().reason, GetParam().reason) << cell.error().message;
  EXPECT_THAT(cell.error().message, HasSubstr(GetParam().message));
}
INSTANTIATE_TEST_SUITE_P(
    Mistakes, CellFileRobot,
    testing::Values(
        RobotMistake{"Controller",
                     kHead + "[[robot]]\nid = \"ma\"\ncontroller = \"laser\"\n" +
                         controller_text("axis", {"q1_mm"}),
                     "BAD_CONTROLLER", "'laser'"},
        RobotMistake{"Axis",
                     kHead + "[[robot]]\nid = \"ma\"\naxes = [\"q7_mm\"]\n" +
                         controller_text("axis", {"q1_mm"}),
                     "BAD_CHANNEL", "'q7_mm'"},
        RobotMistake{"Twice",
                     kHead + "[[robot]]\nid = \"ma\"\n[[robot]]\nid = \"ma\"\n" +
                         controller_text("axis", {"q1_mm"}),
                     "DUPLICATE_ID", "'ma'"},
        RobotMistake{"Id", kHead + "[[robot]]\nid = \"m.a\"\n" + controller_text("axis", {"q1_mm"}),
                     "BAD_ID", "'m.a'"},
        RobotMistake{"PlainName", kHead + kTwoRobots + controller_text("gantry", {"q1_mm"}),
                     "BAD_CHANNEL", "such as ma.q1_mm"},
        RobotMistake{"StrangeName", kHead + kTwoRobots + controller_text("gantry", {"mx.q1_mm"}),
                     "BAD_CHANNEL", "the robots are ma, mn"},
        RobotMistake{"AxisOfNobody",
                     kHead +
                         "[[robot]]\nid = \"ma\"\ncontroller = \"gantry\"\naxes = [\"ma.q1_mm\"]\n"
                         "[[robot]]\nid = \"mn\"\ncontroller = \"hexapod\"\n" +
                         kTwoControllers,
                     "AXIS_OF_NO_ROBOT", "'ma.q2_mm'"},
        RobotMistake{"AxisOfAnother",
                     kHead +
                         "[[robot]]\nid = \"ma\"\ncontroller = \"hexapod\"\n"
                         "[[robot]]\nid = \"mn\"\ncontroller = \"hexapod\"\n" +
                         kTwoControllers,
                     "BAD_CHANNEL", "begins with 'ma.'"},
        RobotMistake{"KeepOutOfOneRobot",
                     kHead + kTwoRobots + kTwoControllers + keep_out_text("ma.q1_mm", "ma.q2_mm"),
                     "BAD_KEEP_OUT", "found axes of one robot"},
        RobotMistake{"KeepOutOfAStranger",
                     kHead + kTwoRobots + kTwoControllers + keep_out_text("ma.q1_mm", "mn.q9_mm"),
                     "BAD_KEEP_OUT", "'mn.q9_mm'"},
        RobotMistake{
            "KeepOutWithoutEffect",
            kHead + kTwoRobots + kTwoControllers + keep_out_text("ma.q1_mm", "mn.q1_mm", "0"),
            "BAD_KEEP_OUT", "found 0"},
        RobotMistake{"KeepOutOfTheZero",
                     kHead + kTwoRobots + kTwoControllers +
                         keep_out_text("ma.q1_mm", "mn.q1_mm", "-1", "0.5"),
                     "BAD_KEEP_OUT", "every run begins with all axes at 0"},
        RobotMistake{"Key",
                     kHead + "[[robot]]\nid = \"ma\"\ncontroler = \"axis\"\n" +
                         controller_text("axis", {"q1_mm"}),
                     "UNKNOWN_KEY", "did you mean controller?"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(CellFileKinds, AreDeclaredOnceWithARoleEach) {
  std::set<std::string_view> ids;
  for (const auto* kind : drivers::all_devices()) {
    EXPECT_TRUE(ids.insert(kind->id).second) << kind->id;
    EXPECT_EQ(static_cast<std::size_t>(kind->role), settings_for(kind->role).index());
    EXPECT_TRUE(kind->read_settings && kind->channels && kind->make) << kind->id;
  }
}

// A model of the robot's motor coordinates was measured with the tool that was mounted.
TEST(CellFileRobots, AnotherToolAsksAndTouchesTheMotorCoordinatesOfItsRobot) {
  const std::string devices = controller_text("gantry", {"ma.q1_mm", "ma.q2_mm"}) +
                              controller_text("hexapod", {"mn.q1_mm"});
  std::string other = kTwoRobots;
  other.replace(other.find("probe-3"), 7, "probe-4");
  const auto after = read(kHead + other + devices);
  ASSERT_TRUE(after) << after.error().message;
  const auto changes = cell_file_difference(kHead + kTwoRobots + devices, *after);
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(sentence(changes[0]), "robot ma: tool probe-3 -> probe-4");
  EXPECT_TRUE(changes[0].asks);
  EXPECT_EQ(changes[0].affects, (std::vector<std::string>{"ma.q1", "ma.q2"}));
}

}  // namespace
}  // namespace driftwise::formats
