// Three set-ups of one robot, joined, against the pose that made them.

#include "server/correction/dataset_join.h"

#include <gmock/gmock.h>

#include <cmath>

#include "server/correction/return_subtraction.h"
#include "tests/unit/correction/set_ups.h"

namespace driftwise::correction::set_ups {
namespace {

using testing::HasSubstr;

double truth(const GridPoint& point, const std::string& symbol) {
  const Pose pose = pose_of(point.q1, point.q2, point.q3);
  return symbol == "x"    ? pose.x
         : symbol == "y"  ? pose.y
         : symbol == "z"  ? pose.z
         : symbol == "rx" ? pose.rx
         : symbol == "ry" ? pose.ry
                          : pose.rz;
}

// Root mean square against the truth at the wanted motor coordinates.
double rms_error(const Dataset& data, const std::string& symbol,
                 const std::vector<GridPoint>& points) {
  double square = 0;
  const auto& values = data.find(symbol)->values;
  for (std::size_t i = 0; i < data.rows; ++i) {
    const double off = values[i] - truth(points[i], symbol);
    square += off * off;
  }
  return std::sqrt(square / static_cast<double>(data.rows));
}

const JoinedChannel& channel(const JoinReport& report, const std::string& symbol) {
  for (const auto& one : report.channels)
    if (one.channel.symbol == symbol) return one;
  throw std::runtime_error("no channel " + symbol);
}

TEST(DatasetJoin, GivesThePoseOfASixDofMeasurementWithinItsStatedUncertainty) {
  const auto joined = join(three(), {});
  ASSERT_TRUE(joined) << joined.error().message;
  const auto points = grid();
  ASSERT_EQ(joined->data.rows, points.size());
  JoinParts six = {measured(kAll)};
  align_zeros({0}, six[0]);
  for (const char* symbol : {"x", "y", "z", "rx", "ry", "rz"}) {
    const double off = rms_error(joined->data, symbol, points);
    const double of_six = rms_error(six[0].data, symbol, points);
    const double u = channel(joined->report, symbol).u.value();
    EXPECT_LT(off, std::hypot(of_six, 1.3 * u)) << symbol << ": u " << u;
    EXPECT_LT(u, 3 * off) << symbol << " is stated too large";
  }
  // Uncorrected, the other set-ups' angles are worth hundreds of nanometres in z.
  EXPECT_GT(rms_error(measured(kThird).data, "z", points), 100e-6);
  EXPECT_LT(rms_error(joined->data, "z", points), 60e-6);
}

TEST(DatasetJoin, SaysWhereEachCoordinateComesFromAndChecksTheOneThatWasSeenTwice) {
  const auto joined = join(three(), {});
  ASSERT_TRUE(joined) << joined.error().message;
  EXPECT_THAT(channel(joined->report, "x").sources, testing::ElementsAre("first"));
  EXPECT_THAT(channel(joined->report, "rz").sources, testing::ElementsAre("first"));
  EXPECT_THAT(channel(joined->report, "z").sources, testing::ElementsAre("third"));
  const auto& ry = channel(joined->report, "ry");
  EXPECT_THAT(ry.sources, testing::ElementsAre("first", "second"));
  ASSERT_TRUE(ry.check);
  EXPECT_NEAR(ry.check->sigma, 0.03 * std::sqrt(2.0), 0.01);  // two readings of 0.03 arcsec
  EXPECT_NEAR(*ry.u, 0.03 / std::sqrt(2.0), 0.008);           // of their mean
  EXPECT_TRUE(joined->report.warnings.empty()) << joined->report.warnings.front();
}

// A length that two sessions measured is a check, whether or not a stage corrects it by the angles
// of both: here the second one's scale is 100 ppm off.
TEST(DatasetJoin, ChecksALengthThatTwoSessionsMeasuredBehindTheirCorrection) {
  JoinParts parts = {measured(kFirst), measured(kFirstAgain), measured(kThird)};
  for (const char* symbol : {"x", "x_path"})
    for (double& value : column(parts[1], symbol).values) value *= 1 + 100e-6;
  const auto joined = join(parts, {});
  ASSERT_TRUE(joined) << joined.error().message;
  const auto& x = channel(joined->report, "x");
  ASSERT_TRUE(x.check);
  // 1.4826 times the median of |100 ppm x|, x even over -1 .. 1: 50 nm, and noise of 25 and 5 nm.
  EXPECT_NEAR(x.check->sigma * 1e6, 74, 20);
  EXPECT_GT(*x.u * 1e6, 30);
  for (auto& part : parts) part.stage.reset();
  const auto uncorrected = join(parts, {});
  ASSERT_TRUE(uncorrected);
  EXPECT_NEAR(x.check->sigma, channel(uncorrected->report, "x").check->sigma, 10e-6);
}

TEST(DatasetJoin, ALengthWithoutTheRotationThatCorrectsItIsMissing) {
  auto parts = three();
  constexpr std::size_t kRow = 40;
  for (auto& part : {&parts[0], &parts[1]}) column(*part, "ry").values[kRow] = kMissing;
  const auto joined = join(parts, {});
  ASSERT_TRUE(joined) << joined.error().message;
  // x and z are moved by ry, y is not (beams meet their mirrors at the diagonal).
  EXPECT_TRUE(is_missing(joined->data.find("x")->values[kRow]));
  EXPECT_TRUE(is_missing(joined->data.find("z")->values[kRow]));
  EXPECT_FALSE(is_missing(joined->data.find("y")->values[kRow]));
  EXPECT_FALSE(is_missing(joined->data.find("x")->values[kRow + 1]));
  EXPECT_THAT(joined->report.warnings, testing::Contains(HasSubstr("missing in 1 of ")));
}

// Servos that rest at +-30 nm: of returns to zero the median is at one of the two, and so much the
// joined zero would be off; the deviations from the mean of three runs are 0, 20 and 40 nm.
TEST(DatasetJoin, KnowsTheHoldingErrorOfServosThatRestAtTwoPlaces) {
  const JoinParts parts = {measured({"first", {"x", "ry", "rz"}, 11, 0, true}),
                           measured({"second", {"y", "rx", "ry"}, 12, 0, true}),
                           measured({"third", {"z"}, 13, 0, true})};
  const auto joined = join(parts, {});
  ASSERT_TRUE(joined) << joined.error().message;
  const auto& data = joined->data;
  const auto motor = [&](const char* q, std::size_t row) { return data.find(q)->values[row]; };
  for (const char* symbol : {"x", "y", "z"}) {
    double sum = 0, squares = 0;
    for (std::size_t row = 0; row < data.rows; ++row) {
      const GridPoint there{motor("q1", row), motor("q2", row), motor("q3", row), false};
      const double off = data.find(symbol)->values[row] - truth(there, symbol);
      sum += off, squares += off * off;
    }
    const double rows = static_cast<double>(data.rows), mean = sum / rows;
    // Of 26 returns of 30 nm: 6 nm.
    EXPECT_LT(std::abs(mean), 15e-6) << symbol;
    const double sigma = std::sqrt(squares / rows - mean * mean);
    EXPECT_NEAR(channel(joined->report, symbol).u.value() / sigma, 1, 0.12) << symbol;
  }
}

// An autocollimator turned about its beam: of two rotations that it reads, each has a share of the
// other.
void turn_autocollimator(JoinPart& part, const char* first, const char* second, double rad) {
  auto& a = column(part, first).values;
  auto& b = column(part, second).values;
  for (std::size_t row = 0; row < part.data.rows; ++row) {
    const double was = a[row];
    a[row] += rad * b[row];
    b[row] -= rad * was;
  }
}

TEST(DatasetJoin, StatesTheRollOfAutocollimatorsInTheRotationsThatOneRunAloneMeasured) {
  auto parts = three();
  turn_autocollimator(parts[0], "ry", "rz", 0.04);
  turn_autocollimator(parts[1], "ry", "rx", -0.03);
  const auto joined = join(parts, {});
  ASSERT_TRUE(joined) << joined.error().message;
  for (const char* symbol : {"rx", "ry", "rz"}) {
    const double off = rms_error(joined->data, symbol, grid());
    const double u = channel(joined->report, symbol).u.value();
    EXPECT_GT(off, 0.03) << symbol;
    EXPECT_NEAR(u / off, 1, 0.25) << symbol << ": error " << off << ", u " << u;
  }
  EXPECT_THAT(
      joined->report.warnings,
      testing::IsSupersetOf({HasSubstr("first is turned about its beam by 39.3 +- 2.3 mrad"),
                             HasSubstr("second is turned about its beam by -28.5 +- 1.8 mrad")}));
}

TEST(DatasetJoin, FindsNoRollWhereASingleRowOfTheCommonRotationIsWrong) {
  auto parts = three();
  column(parts[0], "ry").values[40] += 30;
  const auto joined = join(parts, {});
  ASSERT_TRUE(joined) << joined.error().message;
  for (const auto& warning : joined->report.warnings)
    EXPECT_THAT(warning, testing::Not(HasSubstr("turned about its beam")));
  EXPECT_LT(channel(joined->report, "rz").u.value(), 0.1);
}

TEST(DatasetJoin, JoinsTheRunsOfOneRobotAmongSeveral) {
  auto parts = three();
  for (auto& part : parts) {
    for (auto& column : part.data.columns)
      column.channel.symbol.insert(0, column.channel.symbol.starts_with("t") ? "" : "ma.");
    part.data.columns.push_back({{"mn.q1", "mm"}, std::vector<double>(part.data.rows, 0.5)});
  }
  EXPECT_EQ(measured_robot(parts[0].data), "ma");
  const auto joined = join(parts, {});
  ASSERT_TRUE(joined) << joined.error().message;
  const auto alone = join(three(), {});
  for (const char* symbol : {"x", "y", "z", "rx", "ry", "rz", "q1"})
    EXPECT_EQ(joined->data.find(std::string("ma.") + symbol)->values,
              alone->data.find(symbol)->values);
  EXPECT_EQ(channel(joined->report, "ma.ry").sources, channel(alone->report, "ry").sources);
  ASSERT_TRUE(joined->data.find("mn.q1"));
}

TEST(DatasetJoin, WarnsOfAModelThatMovedOneRunOnly) {
  auto parts = three();
  parts[0].model = "model 4";
  const auto joined = join(parts, {});
  ASSERT_TRUE(joined);
  EXPECT_THAT(joined->report.warnings,
              testing::Contains(HasSubstr("first was moved by model 4 and second by no model")));
}

TEST(DatasetJoin, TakesASecondSessionWithTheSameCommandedCoordinates) {
  auto parts = three();  // a controller that says what it was told instead of what it read
  for (auto& column : parts[1].data.columns)
    if (is_motor_symbol(column.channel.symbol))
      column.values = parts[0].data.find(column.channel.symbol)->values;
  EXPECT_TRUE(join(parts, {}));
}

TEST(DatasetJoin, FindsRowsByTheirNumberWhateverTheOrderOfTheVisit) {
  auto parts = three();
  auto& late = parts[1];  // row 8 was given to the end of its run
  late.row.resize(late.data.rows);
  for (std::size_t i = 0; i < late.row.size(); ++i) late.row[i] = static_cast<std::int64_t>(i);
  std::rotate(late.row.begin() + 7, late.row.begin() + 8, late.row.end());
  for (auto& one : late.data.columns)
    std::rotate(one.values.begin() + 7, one.values.begin() + 8, one.values.end());
  std::rotate(late.data.zero.begin() + 7, late.data.zero.begin() + 8, late.data.zero.end());
  const auto joined = join(parts, {});
  ASSERT_TRUE(joined) << joined.error().message;
  EXPECT_LT(rms_error(joined->data, "y", grid()), 60e-6);
}

TEST(DatasetJoin, SubtractsTheReturnsWithADriftAndLeavesThemOut) {
  auto parts = three();
  for (auto& part : parts)
    for (const char* symbol : {"x", "x_path", "y", "y_path", "z", "z_path"})
      for (auto& one : part.data.columns)
        if (one.channel.symbol == symbol)
          for (std::size_t i = 0; i < part.data.rows; ++i)
            one.values[i] += 20e-9 * part.data.time_s[i];  // 45 um an hour and more
  const auto joined = join(parts, {.subtract_returns = true});
  ASSERT_TRUE(joined) << joined.error().message;
  std::vector<GridPoint> points;
  for (const auto& point : grid())
    if (!point.zero) points.push_back(point);
  ASSERT_EQ(joined->data.rows, points.size());
  EXPECT_LT(rms_error(joined->data, "x", points), 70e-6);
}

}  // namespace
}  // namespace driftwise::correction::set_ups
