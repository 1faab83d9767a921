#include "server/core/channel.h"

#include <gtest/gtest.h>

namespace driftwise {
namespace {

TEST(Channel, HasTheUnitsOfWhatAMachineDoes) {
  for (const char* name : {"speed_rpm", "motor_A", "heater_W", "inverter_Hz", "load_pct"})
    EXPECT_TRUE(parse_channel(name).has_value()) << name;
}

TEST(ParseChannel, SplitsAtTheLastUnderscore) {
  const auto channel = parse_channel("x_std_nm");
  ASSERT_TRUE(channel);
  EXPECT_EQ(channel->symbol, "x_std");
  EXPECT_EQ(channel->unit, "nm");
  EXPECT_EQ(channel->name(), "x_std_nm");
}

class BadChannel : public testing::TestWithParam<const char*> {};
TEST_P(BadChannel, IsRefusedByName) {
  const auto channel = parse_channel(GetParam());
  ASSERT_FALSE(channel);
  EXPECT_EQ(channel.error().code, ErrorCode::invalid_argument);
  EXPECT_EQ(channel.error().reason, "BAD_CHANNEL");
  EXPECT_NE(channel.error().message.find("'" + std::string(GetParam()) + "'"), std::string::npos);
}
INSTANTIATE_TEST_SUITE_P(Table, BadChannel,
                         testing::Values("", "x", "_mm", "x_", "x_furlong", "7x_mm", "a b_mm",
                                         "x_MM"));

TEST(ParseRobotChannel, TakesARobotsIdBeforeItsOwnChannelsOnly) {
  const auto channel = parse_robot_channel("ma.rx_arcsec");
  ASSERT_TRUE(channel);
  EXPECT_EQ(channel->symbol, "ma.rx");
  EXPECT_EQ(channel->unit, "arcsec");
  EXPECT_EQ(robot_of(channel->symbol), "ma");
  EXPECT_EQ(without_robot(channel->symbol), "rx");
  EXPECT_EQ(parse_robot_channel("mn.x_std_nm")->symbol, "mn.x_std");
  EXPECT_EQ(parse_robot_channel("t07_degC")->symbol, "t07");
  EXPECT_EQ(robot_of("q1"), "");
  for (const char* bad :
       {"ma.t07_degC", "ma.ma.x_mm", ".x_mm", "7a.x_mm", "ma.x_furlong", "ma._mm"})
    EXPECT_EQ(parse_robot_channel(bad).error().reason, "BAD_CHANNEL") << bad;
  EXPECT_FALSE(parse_channel("ma.q1_mm")) << "a robot's id is taken where several robots may be";
}

TEST(ChannelKinds, AreToldByTheirNames) {
  EXPECT_TRUE(is_motor_symbol("q12"));
  EXPECT_FALSE(is_motor_symbol("q"));
  EXPECT_TRUE(is_pose_symbol("rz"));
  EXPECT_FALSE(is_pose_symbol("r"));
  EXPECT_TRUE(is_structure_temperature({"t07", "degC"}));
  EXPECT_TRUE(is_structure_temperature({"spindle_nose", "K"})) << "whatever its name";
  EXPECT_FALSE(is_structure_temperature({"t07", "V"}));
  EXPECT_FALSE(is_structure_temperature({"support_set", "degC"})) << "asked for, not measured";
  EXPECT_FALSE(is_structure_temperature({"air_left", "degC"}));
  EXPECT_FALSE(is_structure_temperature({"air", "degC"}));
}

TEST(SummaryUnit, GivesLengthsInNanometresAndAnglesInArcseconds) {
  EXPECT_DOUBLE_EQ(summary_unit("mm").factor, 1e6);
  EXPECT_EQ(summary_unit("um").unit, "nm");
  EXPECT_DOUBLE_EQ(summary_unit("deg").factor, 3600.0);
  EXPECT_EQ(summary_unit("degC").unit, "degC");
}

TEST(Channel, IsLightByTheWordLevelInItsName) {
  for (const char* name : {"level_pct", "level_y_pct", "ma.level_pct", "level_ma_x_pct"})
    EXPECT_TRUE(is_light_level(name)) << name;
  for (const char* name : {"support_power_pct", "humidity_pct", "levels_pct", "level_mm"})
    EXPECT_FALSE(is_light_level(name)) << name;
}

}  // namespace
}  // namespace driftwise
