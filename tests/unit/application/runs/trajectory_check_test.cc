#include "server/application/trajectories/trajectory_check.h"

#include <gtest/gtest.h>

namespace driftwise::application {
namespace {

CellDescription cell() {
  CellDescription c;
  c.name = "linear";
  DeviceDescription axis;
  axis.become<MotionSettings>().axes.push_back({{"q1", "mm"}, "X", -4.5, 4.5, 20});
  c.devices = {axis};
  return c;
}

TEST(CheckTrajectory, CountsWhatIsThere) {
  const auto check = check_trajectory_text(
      cell(), "plan.csv",
      "x_mm,set,line,zero\n0,calibration,1,1\n-4,calibration,1,0\n-3.5,validation,1,0\n"
      "0,calibration,2,1\n");
  ASSERT_TRUE(check) << check.error().message;
  EXPECT_EQ(check->calibration, 3);
  EXPECT_EQ(check->validation, 1);
  EXPECT_EQ(check->zeros, 2);
  EXPECT_EQ(check->lines, 2);
  EXPECT_GT(check->estimated_s, 0);
  EXPECT_TRUE(check->warnings.empty());
}

TEST(CheckTrajectory, NamesRowFieldValueAndLimit) {
  const auto check = check_trajectory_text(cell(), "plan.csv", "q1_mm\n0\n4.6\n5\n");
  ASSERT_FALSE(check);
  EXPECT_EQ(check.error().code, ErrorCode::out_of_range);
  EXPECT_EQ(check.error().reason, "SOFT_LIMIT");
  EXPECT_EQ(check.error().message,
            "plan.csv: row 2: q1_mm = 4.6 mm, the soft limits of axis X are -4.5 to 4.5 mm (and 1 "
            "more values outside)");
}

TEST(CheckTrajectory, RefusesCoordinatesThatTheCellLacks) {
  EXPECT_EQ(check_trajectory_text(cell(), "p", "q2_mm\n0\n").error().reason, "WRONG_COORDINATES");
  const auto two = check_trajectory_text(cell(), "p", "q1_mm,q2_mm\n0,0\n");
  EXPECT_EQ(two.error().reason, "WRONG_COORDINATES");
  EXPECT_NE(two.error().message.find("p: found the coordinates q1_mm, q2_mm, expected one for each "
                                     "axis of cell '"),
            std::string::npos)
      << two.error().message;
  EXPECT_NE(two.error().message.find("': q1_mm, or a pose"), std::string::npos);
}

TEST(CheckTrajectory, RotationsAreWantedPosesOfSeveralAxes) {
  CellDescription three;
  three.name = "tilting";
  for (const char* motor : {"q1", "q2", "q3"})
    three.devices.emplace_back().become<MotionSettings>().axes.push_back(
        {{motor, "mm"}, "X", -1, 1, 0});
  const auto check = check_trajectory_text(
      three, "p", "rx_arcsec,ry_deg,z_mm\n0,0,0\n300,-0.05,0.5\n-300,0.05,1\n");
  ASSERT_TRUE(check) << check.error().message;
  EXPECT_EQ(check->trajectory.points[1].target, (std::vector<double>{300, -180, 0.5}));
  EXPECT_NE(check->warnings.back().size(), 0u);
  // Of one axis, too, a rotation is no motor coordinate.
  const auto one = check_trajectory_text(cell(), "p", "rx_arcsec\n100\n");
  ASSERT_TRUE(one) << one.error().message;
}

CellDescription delta_cell() {
  CellDescription c;
  c.name = "delta";
  c.kinematics.emplace().kind = "delta-vertical";
  for (int i = 0; i < 3; ++i) {
    const Channel motor{"q" + std::to_string(i + 1), "mm"};
    c.devices.emplace_back().become<MotionSettings>().axes.push_back({motor, "X", -0.2, 2.8, 5});
    DeltaBranch branch;
    branch.motor = motor;
    branch.azimuth_deg = 120.0 * i;
    branch.radius_mm = 44.8;
    branch.length_mm = 70;
    c.kinematics->branches.push_back(branch);
  }
  return c;
}

TEST(CheckTrajectory, AsksTheDrawingWhatAPoseNeeds) {
  // Straight up all three carriages go along; sideways one of them must leave its range.
  EXPECT_TRUE(check_trajectory_text(delta_cell(), "p", "x_mm,y_mm,z_mm\n0,0,0\n0,0,2.5\n"));
  EXPECT_TRUE(check_trajectory_text(delta_cell(), "p", "x_mm,y_mm,z_mm\n-0.4,0.3,1.3\n"));
  const auto outside =
      check_trajectory_text(delta_cell(), "plan.csv", "x_mm,y_mm,z_mm\n0,0,1\n0,0,2.9\n");
  ASSERT_FALSE(outside);
  EXPECT_EQ(outside.error().message,
            "plan.csv: row 2: x_mm = 0, y_mm = 0, z_mm = 2.9: needs q1_mm = 2.9000 mm, the soft "
            "limits of axis X are -0.2 to 2.8 mm (and 2 more values outside)");
  auto unknown = delta_cell();
  unknown.kinematics.reset();
  const auto check = check_trajectory_text(unknown, "p", "x_mm,y_mm,z_mm\n0,0,2.9\n");
  ASSERT_TRUE(check);
  bool warned = false;
  for (const auto& warning : check->warnings)
    warned |= warning.find("no [kinematics]") != std::string::npos;
  EXPECT_TRUE(warned);
}

TEST(CheckTrajectory, HoldsForcesAgainstTheCell) {
  const auto reason = [](const CellDescription& c, const char* text) {
    const auto check = check_trajectory_text(c, "p", text);
    return check ? std::string() : check.error().reason;
  };
  EXPECT_EQ(reason(cell(), "q1_mm,force_N\n0,0\n"), "") << "no force is no force anywhere";
  EXPECT_EQ(reason(cell(), "q1_mm,force_N\n0,2.305\n"), "NO_LOAD");
  auto loaded = cell();
  loaded.load = LoadDescription{4.0, 0, 9.81};
  EXPECT_EQ(reason(loaded, "q1_mm,force_N\n0,2.305\n"), "");
  EXPECT_EQ(reason(loaded, "q1_mm,force_N\n0,4.5\n"), "FORCE_LIMIT");
  EXPECT_EQ(reason(loaded, "q1_mm,force_N\n0,-1\n"), "FORCE_LIMIT");
}

TEST(CheckTrajectory, WarnsOfWhatIsProbablyNotMeant) {
  const auto check = check_trajectory_text(cell(), "p", "q1_mm\n1\n1\n2\n");
  ASSERT_TRUE(check);
  ASSERT_EQ(check->warnings.size(), 3u);  // a repeated position, no validation, no zeros
  EXPECT_NE(check->warnings[2].find("a passage in the data and in no fit"), std::string::npos)
      << check->warnings[2];
}

}  // namespace
}  // namespace driftwise::application
