// Wrong joins of three set-ups, each refused with its reason.

#include <gmock/gmock.h>

#include <algorithm>

#include "server/correction/dataset_join.h"
#include "tests/unit/correction/set_ups.h"

namespace driftwise::correction::set_ups {
namespace {

using testing::HasSubstr;

// The value of the row before in every row.
void shift_rows(DatasetColumn& of) {
  std::rotate(of.values.begin(), of.values.end() - 1, of.values.end());
}

Error refusal(JoinParts parts, const JoinRules& rules = {}) {
  const auto joined = join(std::move(parts), rules);
  return joined ? Error{ErrorCode::internal, "NOT_REFUSED", ""} : joined.error();
}

// The columns of one robot among several: "q1" as "ma.q1".
void name_robot(JoinPart& part, const std::string& robot) {
  for (auto& column : part.data.columns)
    if (!column.channel.symbol.starts_with("t")) column.channel.symbol.insert(0, robot + ".");
}

TEST(DatasetJoin, RefusesRunsOfTwoRobots) {
  auto parts = three();
  name_robot(parts[0], "ma");
  name_robot(parts[1], "ma");
  name_robot(parts[2], "mn");
  const auto refused = refusal(parts);
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

}  // namespace
}  // namespace driftwise::correction::set_ups
