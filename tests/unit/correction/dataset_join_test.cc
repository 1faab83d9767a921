// Three set-ups of one robot, joined, against the pose that made them; and wrong joins, each
// refused for what it is.

#include "server/correction/dataset_join.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "server/core/units.h"
#include "server/correction/return_subtraction.h"

namespace driftwise::correction {
namespace {

using testing::HasSubstr;

constexpr double kLever_mm = 12;

struct Pose {
  double x, y, z, rx, ry, rz;  // mm, arcsec
};

// A robot of three motors with parasitic rotations of some arcseconds.
Pose pose_of(double q1, double q2, double q3) {
  return {
      q1 + 0.01 * q2 - 0.002 * q1 * q3, q2 - 0.01 * q1 + 0.001 * q1 * q1, q3 + 0.003 * q1 * q2,
      4.0 * q2 + 1.5 * q1 * q3,         -6.0 * q1 + 0.8 * q2 * q2,        3.0 * q3 - 2.0 * q1 * q2};
}

struct SetUp {
  const char* name;
  std::vector<std::string> measures;
  unsigned seed;
  double drift_nm;          // of every length over the session
  bool two_places = false;  // each motor rests 30 nm to either side, never between
};
const SetUp kFirst{"first", {"x", "ry", "rz"}, 1, 40};
const SetUp kSecond{"second", {"y", "rx", "ry"}, 2, -30};
const SetUp kThird{"third", {"z"}, 3, 20};
const SetUp kFirstAgain{"again", {"x", "ry", "rz"}, 5, -20};
const SetUp kAll{"all", {"x", "y", "z", "rx", "ry", "rz"}, 4, 40};

struct GridPoint {
  double q1, q2, q3;
  bool zero;
};
// 5 x 5 x 5, a return to zero before each line and at the end.
std::vector<GridPoint> grid() {
  std::vector<GridPoint> points;
  for (int a = -2; a <= 2; ++a)
    for (int b = -2; b <= 2; ++b) {
      points.push_back({0, 0, 0, true});
      for (int c = -2; c <= 2; ++c) points.push_back({0.5 * c, 0.5 * b, 0.5 * a, false});
    }
  points.push_back({0, 0, 0, true});
  return points;
}

// What a set-up reads: paths along beams that meet their mirrors kLever_mm off the centre, with
// 5 nm and 0.03 arcsec of noise and 25 nm of holding error. Lengths as the cell's own correction
// stage leaves them: each set-up knows its own angles only.
JoinPart measured(const SetUp& set_up) {
  std::mt19937 random(set_up.seed);
  std::normal_distribution<double> normal;
  JoinPart part;
  part.name = set_up.name;
  part.tool = "cube";
  Stage stage;
  stage.cosine = true;
  for (auto& beam : stage.beams) beam.at_zero_mm = {kLever_mm, kLever_mm, kLever_mm};
  part.stage = stage;
  auto& data = part.data;
  const auto column = [&data](const char* symbol, const char* unit) {
    data.columns.push_back({{symbol, unit}, {}});
  };
  for (const char* q : {"q1", "q2", "q3"}) column(q, "mm");
  for (const auto& symbol : set_up.measures) {
    if (symbol.size() == 1) column((symbol + "_path").c_str(), "mm");
    column(symbol.c_str(), symbol.size() == 1 ? "mm" : "arcsec");
  }
  column("t05", "degC");
  const auto points = grid();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& point = points[i];
    const double share = static_cast<double>(i) / static_cast<double>(points.size());
    std::array<double, 3> q{point.q1, point.q2, point.q3};
    for (double& one : q) {
      const double holding = normal(random);
      one += set_up.two_places ? std::copysign(30e-6, holding) : 25e-6 * holding;
    }
    Pose pose = pose_of(q[0], q[1], q[2]);
    const double drift_mm = set_up.drift_nm * 1e-6 * share;
    pose.x += drift_mm, pose.y += drift_mm, pose.z += drift_mm;
    const double rx = rad_from_arcsec(pose.rx), ry = rad_from_arcsec(pose.ry),
                 rz = rad_from_arcsec(pose.rz);
    // Rigid body: the mirror's point at the lever a moves by rotation x a.
    const std::array<double, 3> path = {
        (pose.x + (ry - rz) * kLever_mm) / (std::cos(ry) * std::cos(rz)),
        (pose.y + (rz - rx) * kLever_mm) / (std::cos(rx) * std::cos(rz)),
        (pose.z + (rx - ry) * kLever_mm) / (std::cos(rx) * std::cos(ry))};
    const std::array<double, 3> angle = {pose.rx, pose.ry, pose.rz};
    Vector3 read_mm{};
    Tilt read;
    for (const auto& symbol : set_up.measures) {
      const auto axis = static_cast<std::size_t>(symbol.back() - 'x');
      if (symbol.size() == 1)
        read_mm[axis] = path[axis] + 5e-6 * normal(random);
      else
        (axis == 0   ? read.rx_arcsec
         : axis == 1 ? read.ry_arcsec
                     : read.rz_arcsec) = angle[axis] + 0.03 * normal(random);
    }
    const auto corrected = pose_from_paths(read_mm, read, stage);
    std::size_t at = 0;
    const auto put = [&](double value) { data.columns[at++].values.push_back(value); };
    for (const double one : q) put(one);
    for (const auto& symbol : set_up.measures) {
      const auto axis = static_cast<std::size_t>(symbol.back() - 'x');
      if (symbol.size() == 1) {
        put(read_mm[axis]);
        put(corrected[axis]);
      } else {
        put(axis == 0 ? read.rx_arcsec : axis == 1 ? read.ry_arcsec : read.rz_arcsec);
      }
    }
    put(20 + 0.1 * share);
    data.time_s.push_back(15.0 * static_cast<double>(i));
    data.zero.push_back(point.zero ? 1 : 0);
  }
  data.rows = points.size();
  return part;
}

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

JoinParts three() { return {measured(kFirst), measured(kSecond), measured(kThird)}; }

DatasetColumn& column(JoinPart& part, const std::string& symbol) {
  for (auto& one : part.data.columns)
    if (one.channel.symbol == symbol) return one;
  throw std::runtime_error("no column " + symbol);
}

// The value of the row before in every row.
void shift_rows(DatasetColumn& of) {
  std::rotate(of.values.begin(), of.values.end() - 1, of.values.end());
}

Error refusal(JoinParts parts, const JoinRules& rules = {}) {
  const auto joined = join(std::move(parts), rules);
  return joined ? Error{ErrorCode::internal, "NOT_REFUSED", ""} : joined.error();
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
  auto two = parts;
  for (auto& column : two[2].data.columns)
    if (column.channel.symbol.starts_with("ma.")) column.channel.symbol.replace(0, 3, "mn.");
  std::erase_if(two[2].data.columns,
                [](const auto& column) { return column.channel.symbol == "mn.q1"; });
  const auto refused = refusal(two);
  EXPECT_EQ(refused.reason, "NOTHING_TO_JOIN");
  EXPECT_THAT(refused.message, HasSubstr("second measured robot ma and third robot mn"));
}

TEST(DatasetJoin, RefusesRowsThatAreShiftedByOne) {
  auto parts = three();
  for (auto& one : parts[1].data.columns)  // with their motor coordinates: another trajectory
    if (one.channel.symbol != "t05") shift_rows(one);
  auto refused = refusal(parts);
  EXPECT_EQ(refused.reason, "TRAJECTORIES_DIFFER");
  EXPECT_THAT(refused.message, HasSubstr("row 2"));

  parts = three();
  for (const char* symbol : {"x", "x_path", "ry", "rz"}) shift_rows(column(parts[0], symbol));
  refused = refusal(parts);
  EXPECT_EQ(refused.reason, "ROWS_SHIFTED");
  EXPECT_THAT(refused.message, HasSubstr("1 row later"));

  parts = three();  // nothing but the angles, which the motors explain in part only
  for (const char* symbol : {"rx", "ry"}) shift_rows(column(parts[1], symbol));
  EXPECT_EQ(refusal(parts).reason, "ROWS_SHIFTED");
}

TEST(DatasetJoin, RefusesSetUpsThatAreSwapped) {
  auto parts = three();
  // The run that is called the first was made in the second set-up, and the other way round.
  column(parts[0], "rz").channel.symbol = "swap";
  column(parts[0], "ry").channel.symbol = "rz";
  column(parts[0], "swap").channel.symbol = "ry";
  std::swap(column(parts[0], "ry").values, column(parts[1], "rx").values);
  std::swap(column(parts[0], "rz").values, column(parts[1], "ry").values);
  const auto refused = refusal(parts);
  EXPECT_EQ(refused.reason, "SETUPS_SWAPPED") << refused.message;
}

Trajectory wanted_in(const char* first, const char* second, const char* third) {
  Trajectory wanted;
  wanted.coordinates = {{first, "mm"}, {second, "mm"}, {third, "mm"}};
  for (const auto& point : grid()) {
    TrajectoryPoint row;
    row.target = {point.q1, point.q2, point.q3};
    row.zero = point.zero;
    wanted.points.push_back(row);
  }
  return wanted;
}

TEST(DatasetJoin, RefusesALengthThatFollowsAnotherWantedCoordinate) {
  auto parts = three();
  const Trajectory wanted = wanted_in("x", "y", "z");
  for (auto& part : parts) part.trajectory = wanted;
  ASSERT_TRUE(join(parts, {}));
  std::swap(column(parts[0], "x").values, column(parts[1], "y").values);
  const auto refused = refusal(parts);
  EXPECT_EQ(refused.reason, "SETUPS_SWAPPED");
  EXPECT_THAT(refused.message, HasSubstr("x_mm of first follows the wanted y_mm"));
}

TEST(DatasetJoin, NamesTheRowInWhichTrajectoriesDiffer) {
  auto parts = three();
  const Trajectory wanted = wanted_in("q1", "q2", "q3");
  for (auto& part : parts) part.trajectory = wanted;
  ASSERT_TRUE(join(parts, {}));
  parts[2].trajectory->points[16].target[1] += 0.25;
  const auto refused = refusal(parts);
  EXPECT_EQ(refused.reason, "TRAJECTORIES_DIFFER");
  EXPECT_THAT(refused.message, HasSubstr("row 17: q2_mm is "));
}

TEST(DatasetJoin, RefusesAnotherToolAnotherTemperatureAndAnotherZero) {
  auto parts = three();
  parts[1].tool = "weight";
  EXPECT_EQ(refusal(parts).reason, "TOOLS_DIFFER");

  parts = three();
  for (double& degc : column(parts[2], "t05").values) degc += 0.8;
  auto refused = refusal(parts);
  EXPECT_EQ(refused.reason, "TEMPERATURES_DIFFER");
  EXPECT_THAT(refused.message, HasSubstr("0.800 K apart, limit 0.5 K"));
  JoinRules wide;
  wide.max_temperature_difference_k = 1;
  const auto joined = join(parts, wide);
  ASSERT_TRUE(joined) << joined.error().message;
  EXPECT_NEAR(*joined->report.temperature_difference_k, 0.8, 1e-9);

  parts = three();
  parts[1].trajectory = parts[0].trajectory = Trajectory{{{"q1", "mm"}}, {}};
  for (const auto& point : grid()) {
    TrajectoryPoint row;
    row.target = {point.q1};
    row.zero = point.zero;
    for (auto* part : {&parts[0], &parts[1]}) part->trajectory->points.push_back(row);
  }
  parts.pop_back();
  for (double& mm : column(parts[1], "q1").values) mm += 0.004;
  refused = refusal(parts);
  EXPECT_EQ(refused.reason, "ZEROS_DIFFER");
  EXPECT_THAT(refused.message, HasSubstr("limit 2000 nm"));
}

TEST(DatasetJoin, WarnsOfAModelThatMovedOneRunOnly) {
  auto parts = three();
  parts[0].model = "model 4";
  const auto joined = join(parts, {});
  ASSERT_TRUE(joined);
  EXPECT_THAT(joined->report.warnings,
              testing::Contains(HasSubstr("first was moved by model 4 and second by no model")));
}

TEST(DatasetJoin, RefusesWhatIsNoJoin) {
  EXPECT_EQ(refusal({measured(kFirst)}).reason, "NOTHING_TO_JOIN");
  EXPECT_EQ(refusal({}).reason, "NOTHING_TO_JOIN");
  auto parts = three();
  parts[2].data.columns.erase(parts[2].data.columns.begin() + 3, parts[2].data.columns.begin() + 5);
  EXPECT_EQ(refusal(parts).reason, "NOTHING_TO_JOIN");
  parts = three();
  parts[2].row.resize(parts[2].data.rows);
  for (std::size_t i = 0; i < parts[2].row.size(); ++i)
    parts[2].row[i] = 1000 + static_cast<std::int64_t>(i);
  EXPECT_EQ(refusal(parts).reason, "NO_COMMON_ROWS");
}

TEST(DatasetJoin, RefusesOneMeasurementGivenTwice) {
  auto parts = three();
  parts.push_back(parts[1]);
  parts[3].name = "copy";
  const auto refused = refusal(parts);
  EXPECT_EQ(refused.reason, "NOTHING_TO_JOIN");
  EXPECT_THAT(refused.message, HasSubstr("part 2 (second) and part 4 (copy) are the same"));
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
}  // namespace driftwise::correction
