#include "server/application/recording/pose_stage.h"

#include <gtest/gtest.h>

#include "server/application/motion/datum_opening.h"

namespace driftwise::application {
namespace {

constexpr double kArcsec = 4.848136811095360e-6;  // rad, pi / 648000

CellDescription three_lasers(bool corrected) {
  CellDescription cell;
  for (const char* axis : {"x", "y", "z"}) {
    DeviceDescription laser;
    laser.id = std::string("laser-") + axis;
    laser.become<LengthSettings>().channel = {axis, "mm"};
    cell.devices.push_back(laser);
  }
  DeviceDescription collimator;
  collimator.become<AngleSettings>().angles = {
      {{"rx", "arcsec"}, 1, 1, 0}, {{"ry", "arcsec"}, 2, 1, 0}, {{"rz", "arcsec"}, 1, 1, 0}};
  cell.devices.push_back(collimator);
  if (corrected) {
    BeamDescription beam;
    beam.length = {"x", "mm"};
    beam.offset_mm = {0, 0, 10};
    beam.offset_per_mm = {0, -1, -1};
    cell.correction = CorrectionDescription{false, {beam}};
  }
  return cell;
}

const std::vector<ChannelValue> kRaw = {
    {"x_mm", 1.0},      {"air_x_degC", 21.5}, {"y_mm", 0.5},     {"z_mm", 2.0},
    {"rx_arcsec", 3.0}, {"ry_arcsec", 60.0},  {"rz_arcsec", 0.0}};

// Two robots with the same tilts and beams, of which one is turned.
TEST(PoseStage, CorrectsEachRobotByItsOwnRotations) {
  CellDescription cell;
  CorrectionDescription correction;
  std::vector<ChannelValue> raw;
  for (const std::string robot : {"ma.", "mn."}) {
    DeviceDescription laser, collimator;
    laser.become<LengthSettings>().channel = {robot + "x", "mm"};
    collimator.become<AngleSettings>().angles = {{{robot + "ry", "arcsec"}, 1, 1, 0}};
    cell.devices.push_back(laser);
    cell.devices.push_back(collimator);
    BeamDescription beam;
    beam.length = {robot + "x", "mm"};
    beam.offset_mm = {0, 0, 10};
    correction.beams.push_back(beam);
    raw.push_back({robot + "x_mm", 1.0});
    raw.push_back({robot + "ry_arcsec", robot == "ma." ? 0.0 : 60.0});
  }
  cell.correction = correction;
  const auto pose = PoseStage(cell).pose(raw);
  EXPECT_NEAR(*find_value(pose, "ma.x_mm"), 1.0, 1e-12);
  EXPECT_NEAR(*find_value(pose, "mn.x_mm"), 1.0 - 60 * kArcsec * 10, 1e-9);
  EXPECT_EQ(*find_value(pose, "mn.x_path_mm"), 1.0);
  EXPECT_EQ(*find_value(pose, "mn.ry_arcsec"), 60.0);
}

TEST(PoseStage, PutsThePathBesideTheCorrectedPose) {
  PoseStage stage(three_lasers(true));
  stage.set_zero({{"ry_arcsec", 20.0}});
  const auto pose = stage.pose(kRaw);
  EXPECT_EQ(*find_value(pose, "x_path_mm"), 1.0);
  // The tilt since the zero is 40", the lever 10 mm less the 2 mm that the cube has risen.
  EXPECT_NEAR(*find_value(pose, "x_mm"), 1.0 - 40 * kArcsec * 8.0, 1e-12);
  EXPECT_EQ(*find_value(pose, "y_mm"), 0.5) << "this beam has no offset";
  EXPECT_EQ(*find_value(pose, "ry_arcsec"), 40.0);
  EXPECT_EQ(*find_value(pose, "rx_arcsec"), 3.0);
  EXPECT_EQ(*find_value(pose, "air_x_degC"), 21.5);
  EXPECT_EQ(pose.size(), kRaw.size() + 3) << "each channel once, three paths more";
}

TEST(PoseStage, LeavesAPoseOutThatNoRawValueStandsFor) {
  PoseStage stage(three_lasers(true));
  const auto pose = stage.pose({{"x_mm", 1.0}, {"ry_arcsec", 0.0}});
  EXPECT_TRUE(find_value(pose, "x_mm"));
  EXPECT_FALSE(find_value(pose, "y_mm"));
  EXPECT_FALSE(find_value(pose, "y_path_mm"));
}

TEST(PoseStage, WithoutACorrectionOnlyCountsRotationsFromTheZero) {
  PoseStage stage(three_lasers(false));
  EXPECT_FALSE(stage.is_identity());
  stage.set_zero({{"ry_arcsec", 20.0}});
  const auto pose = stage.pose(kRaw);
  EXPECT_EQ(*find_value(pose, "x_mm"), 1.0);
  EXPECT_FALSE(find_value(pose, "x_path_mm"));
  EXPECT_EQ(*find_value(pose, "ry_arcsec"), 40.0);
}

TEST(PoseStage, IsTheIdentityForOneLength) {
  CellDescription cell;
  cell.devices.emplace_back().become<LengthSettings>().channel = {"x", "mm"};
  PoseStage stage(cell);
  EXPECT_TRUE(stage.is_identity());
  EXPECT_EQ(stage.pose(kRaw).size(), kRaw.size());
}

TEST(PoseStage, ShowsRawReadingsUnderNamesOfTheirOwn) {
  PoseStage stage(three_lasers(true));
  const auto shown =
      stage.under_raw_names({"laser-x", {}, {}, 1, {{"x_mm", 1.0}, {"ry_arcsec", 2}}});
  EXPECT_EQ(shown.values[0].channel, "x_path_mm");
  EXPECT_EQ(shown.values[1].channel, "ry_raw_arcsec");
}

TEST(Closure, IsOfEveryLengthAndTheLargestIsNamed) {
  const auto cell = three_lasers(true);
  const DatumRecord datum;
  const auto closure =
      closure_nm(cell, datum, {{"x_mm", 3e-6}, {"y_mm", -40e-6}, {"t01_degC", 20.0}});
  ASSERT_EQ(closure.size(), 3u);
  EXPECT_NEAR(closure[0], 3, 1e-9);
  EXPECT_NEAR(largest_nm(closure), -40, 1e-9);
  EXPECT_TRUE(is_missing(closure[2]));
  EXPECT_TRUE(is_missing(largest_nm({})));
}

}  // namespace
}  // namespace driftwise::application
