#include "server/application/trajectory_check.h"

#include <gtest/gtest.h>

namespace driftwise::application {
namespace {

CellDescription cell() {
  CellDescription c;
  c.name = "linear";
  DeviceDescription axis;
  axis.axes.push_back({{"q1", "mm"}, "X", -4.5, 4.5, 20});
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
  EXPECT_EQ(check_trajectory_text(cell(), "p", "q1_mm,q2_mm\n0,0\n").error().reason,
            "WRONG_COORDINATES");
}

TEST(CheckTrajectory, WarnsOfWhatIsProbablyNotMeant) {
  const auto check = check_trajectory_text(cell(), "p", "q1_mm\n1\n1\n2\n");
  ASSERT_TRUE(check);
  EXPECT_EQ(check->warnings.size(), 3u);  // a repeated position, no validation, no zeros
}

}  // namespace
}  // namespace driftwise::application
