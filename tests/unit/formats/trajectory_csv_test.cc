#include "server/formats/csv/trajectory_csv.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

namespace driftwise::formats {
namespace {

TEST(ReadTrajectoryCsv, ReadsCoordinatesSetsLinesAndZeros) {
  const auto trajectory = read_trajectory_csv(
      "# driftwise-trajectory: "
      "1\nq1_mm,set,line,zero,force_N,dwell_s\n0,calibration,0,1,,\n1.5,validation,0,0,50,2.5\n",
      "plan.csv");
  ASSERT_TRUE(trajectory) << trajectory.error().message;
  ASSERT_EQ(trajectory->points.size(), 2u);
  EXPECT_EQ(trajectory->coordinates, (std::vector<Channel>{{"q1", "mm"}}));
  EXPECT_TRUE(trajectory->points[0].zero);
  EXPECT_FALSE(trajectory->points[0].force_n);
  EXPECT_EQ(trajectory->points[1].target, (std::vector<double>{1.5}));
  EXPECT_EQ(trajectory->points[1].set, PointSet::validation);
  EXPECT_EQ(trajectory->points[1].force_n, 50.0);
  EXPECT_EQ(trajectory->points[1].dwell_s, 2.5);
}

TEST(ReadTrajectoryCsv, TakesOneLineOfCalibrationWhenNothingElseIsSaid) {
  const auto trajectory = read_trajectory_csv("x_mm,y_mm\n1,2\n3,4\n", "plan.csv");
  ASSERT_TRUE(trajectory) << trajectory.error().message;
  EXPECT_EQ(trajectory->coordinates[1].symbol, "y");
  EXPECT_EQ(trajectory->points[1].target, (std::vector<double>{3, 4}));
  EXPECT_EQ(trajectory->points[1].line, 0);
  EXPECT_EQ(trajectory->points[1].set, PointSet::calibration);
}

TEST(ReadTrajectoryCsv, TakesRotationsInArcsecAndDegrees) {
  const auto trajectory = read_trajectory_csv("rx_arcsec,ry_deg,z_mm\n-30,0.01,1.5\n", "plan.csv");
  ASSERT_TRUE(trajectory) << trajectory.error().message;
  EXPECT_EQ(trajectory->coordinates,
            (std::vector<Channel>{{"rx", "arcsec"}, {"ry", "arcsec"}, {"z", "mm"}}));
  EXPECT_EQ(trajectory->points[0].target, (std::vector<double>{-30, 36, 1.5}));
}

TEST(ReadTrajectoryCsv, TakesCoordinatesOfSeveralRobots) {
  const auto trajectory = read_trajectory_csv("ma.q1_mm,mn.q1_mm\n1,2\n", "plan.csv");
  ASSERT_TRUE(trajectory) << trajectory.error().message;
  EXPECT_EQ(trajectory->coordinates, (std::vector<Channel>{{"ma.q1", "mm"}, {"mn.q1", "mm"}}));
}

struct TrajectoryMistake {
  const char* name;
  const char* text;
  const char* reason;
  const char* says;
};
class BadTrajectory : public testing::TestWithParam<TrajectoryMistake> {};
TEST_P(BadTrajectory, IsRefusedWithFileLineFieldFoundAndExpected) {
  const auto trajectory = read_trajectory_csv(GetParam().text, "plan.csv");
  ASSERT_FALSE(trajectory);
  EXPECT_EQ(trajectory.error().code, ErrorCode::invalid_argument);
  EXPECT_EQ(trajectory.error().reason, GetParam().reason);
  EXPECT_TRUE(trajectory.error().message.find(GetParam().says) != std::string::npos)
      << trajectory.error().message;
}
INSTANTIATE_TEST_SUITE_P(
    Table, BadTrajectory,
    testing::Values(TrajectoryMistake{"Empty", "", "EMPTY_FILE", "plan.csv:1: "},
                    TrajectoryMistake{"NoRows", "q1_mm\n", "NO_ROWS", "plan.csv:1: "},
                    TrajectoryMistake{"NoCoordinates", "set,line\ncalibration,0\n",
                                      "NO_COORDINATES", "expected q1_mm"},
                    TrajectoryMistake{"Mixed", "q1_mm,x_mm\n0,0\n", "MIXED_COORDINATES",
                                      "found q1_mm and x_mm"},
                    TrajectoryMistake{"Unknown", "q1_mm,sett\n0,calibration\n", "UNKNOWN_COLUMN",
                                      "plan.csv:1: column 2: found 'sett'"},
                    TrajectoryMistake{"LengthOfARotation", "rx_mm\n0\n", "UNKNOWN_COLUMN",
                                      "found 'rx_mm'"},
                    TrajectoryMistake{"RotationTwice", "rx_deg,rx_arcsec\n0,0\n",
                                      "DUPLICATE_COLUMN", "found 'rx_arcsec'"},
                    TrajectoryMistake{"MixedOfRobots", "ma.q1_mm,mn.x_mm\n0,0\n",
                                      "MIXED_COORDINATES", "found ma.q1_mm and mn.x_mm"},
                    TrajectoryMistake{"HoleInARotation", "rx_deg,line\n,0\n", "MISSING_COORDINATE",
                                      "expected a number in deg"},
                    TrajectoryMistake{"OtherUnit", "q1_um\n0\n", "UNKNOWN_COLUMN", "found 'q1_um'"},
                    TrajectoryMistake{"Hole", "q1_mm,line\n,0\n", "MISSING_COORDINATE",
                                      "plan.csv:2: column q1_mm: found nothing"},
                    TrajectoryMistake{"LineBack", "q1_mm,line\n0,1\n0,0\n", "LINE_DECREASES",
                                      "plan.csv:3: column line: found 0 after 1"},
                    TrajectoryMistake{"ZeroElsewhere", "q1_mm,zero\n0.5,1\n", "ZERO_NOT_AT_ZERO",
                                      "plan.csv:2: column zero"},
                    TrajectoryMistake{"NegativeDwell", "q1_mm,dwell_s\n0,-1\n", "BAD_DWELL",
                                      "found -1, expected 0 to 604800 s"},
                    TrajectoryMistake{"BadSet", "q1_mm,set\n0,calib\n", "BAD_SET", "found 'calib'"},
                    TrajectoryMistake{"Infinity", "q1_mm\ninf\n", "BAD_NUMBER", "found 'inf'"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(TrajectoryCsv, ReadsBackWhatItWrites) {
  Trajectory trajectory;
  trajectory.coordinates = {{"q1", "mm"}, {"q2", "mm"}};
  trajectory.points = {{.target = {0, 0}, .zero = true, .force_n = {}, .dwell_s = {}},
                       {.target = {1.0 / 3.0, -2.5},
                        .set = PointSet::validation,
                        .line = 4,
                        .force_n = 0.5,
                        .dwell_s = {}}};
  const auto back = read_trajectory_csv(write_trajectory_csv(trajectory), "plan.csv");
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->points[1].target, trajectory.points[1].target);
  EXPECT_EQ(back->points[1].line, 4);
  EXPECT_EQ(back->points[1].force_n, 0.5);
  EXPECT_FALSE(back->points[0].force_n);
  EXPECT_TRUE(back->points[0].zero);
}

TEST(TrajectoryCsv, ReadsThePublishedPlan) {
  std::ifstream file(DRIFTWISE_SOURCE_DIR "/deploy/cells/linear-axis/trajectories/published.csv");
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const auto plan = read_trajectory_csv(text, "published.csv");
  ASSERT_TRUE(plan) << plan.error().message;
  EXPECT_EQ(plan->points.size(), 1008u);  // the study: 18 positions, 56 times
}

}  // namespace
}  // namespace driftwise::formats
