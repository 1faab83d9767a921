#include "server/standards/approaches.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/core/data/row_marks.h"
#include "tests/unit/standards/standards_data.h"

namespace driftwise::standards {
namespace {

std::vector<ApproachSide> sides_of(const Dataset& data) {
  std::vector<ApproachSide> out;
  const auto approaches = approaches_of(data, {"q1", "q1_cmd", "x"});
  for (const auto& approach : *approaches) out.push_back(approach.side);
  return out;
}

TEST(Approaches, AreReadOffTheOrderOfTheCommands) {
  using enum ApproachSide;
  EXPECT_THAT(sides_of(visits_of({{0, 0}, {1, 0}, {1, 0}, {-1, 0}, {0, 0}})),
              testing::ElementsAre(unknown, up, up, down, up));
}

TEST(Approaches, AReadingAtTheSamePlaceIsNoMove) {
  const auto approaches =
      approaches_of(visits_of({{0, 0}, {1, 0}, {1, 0}, {-1, 0}}), {"q1", "q1_cmd", "x"});
  EXPECT_FALSE(approaches->at(2).moved);
  EXPECT_TRUE(approaches->at(3).moved);
}

TEST(Approaches, TurnRoundBetweenTwoReadingsThatTheDatasetSaysWereOverrun) {
  auto data = visits_of({{0, 0}, {1, 0}, {2, 0}, {2, 0}, {1, 0}, {1, 0}, {0, 0}});
  data.metadata = {{"overruns", "yes"}};
  using enum ApproachSide;
  EXPECT_THAT(sides_of(data), testing::ElementsAre(unknown, up, up, down, down, down, down))
      << "at 2 the axis turned, at 1 it went on";
}

// A compensated run: wanted x, and a command that the model makes of it. Passages have a command
// alone.
Dataset compensated(const std::vector<std::pair<double, double>>& wanted_and_commanded_mm) {
  Dataset data = visits_of({});
  data.rows = wanted_and_commanded_mm.size();
  data.columns.push_back({{"x_target", "mm"}, {}});
  for (const auto& [wanted_mm, commanded_mm] : wanted_and_commanded_mm) {
    data.columns[0].values.push_back(commanded_mm);
    data.columns[1].values.push_back(wanted_mm);
    data.columns[2].values.push_back(wanted_mm);
    data.excluded.push_back(is_missing(wanted_mm) ? kPassageRow : kInUse);
  }
  return data;
}

std::vector<ApproachSide> sides_of_target(const Dataset& data) {
  std::vector<ApproachSide> out;
  const auto approaches = approaches_of(data, {"q1", "x_target", "x"});
  for (const auto& approach : *approaches) out.push_back(approach.side);
  return out;
}

TEST(Approaches, GoOverThePlacesBesideThePlanOfACompensatedRun) {
  using enum ApproachSide;
  EXPECT_THAT(sides_of_target(compensated({{4, 4.001},
                                           {2, 2.001},
                                           {kMissing, 0.501},
                                           {kMissing, 0.401},
                                           {0.5, 0.501},
                                           {-2, -1.999}})),
              testing::ElementsAre(unknown, down, up, down))
      << "0.5 was looked at again from below";
}

TEST(Approaches, AreNotWhatACompensationAddsAtOnePlace) {
  using enum ApproachSide;
  EXPECT_THAT(sides_of_target(compensated({{4, 4.001},
                                           {2, 2.001},
                                           {2, 2.001002},
                                           {kMissing, 0.5},
                                           {0.5, 0.500003},
                                           {0.5, 0.500001}})),
              testing::ElementsAre(unknown, down, down, down, down));
}

TEST(Approaches, RememberWhereTheAxisWasWhenNothingWasMeasuredThere) {
  auto data = visits_of({{0, 0}, {2, 0}, {1, 0}});
  data.columns[1].values[1] = kMissing;  // the beam was broken
  using enum ApproachSide;
  EXPECT_THAT(sides_of(data), testing::ElementsAre(unknown, down));
}

TEST(Approaches, RememberWhereTheAxisWasInARowThatIsKeptOut) {
  auto data = visits_of({{0, 0}, {2, 0}, {1, 0}});
  data.excluded = {0, 1, 0};
  using enum ApproachSide;
  EXPECT_THAT(sides_of(data), testing::ElementsAre(unknown, down));
}

TEST(Positions, HoldTheirVisitsBySideAndLeaveReturnsToZeroOut) {
  auto data = visits_of({{0, 0}, {2, 0}, {1, 0}, {0, 0}, {1, 0}});
  data.zero = {1, 0, 0, 1, 0};
  const auto positions = positions_of(*approaches_of(data, {"q1", "q1_cmd", "x"}));
  ASSERT_EQ(positions.size(), 2U);
  EXPECT_EQ(positions[0].target_mm, 1);
  EXPECT_EQ(positions[0].up.size(), 1U) << "from the zero";
  EXPECT_EQ(positions[0].down.size(), 1U);
}

TEST(AxisColumns, AreFoundByTheAxis) {
  Dataset data;
  data.columns = {{{"q2_cmd", "mm"}, {}}, {{"y", "mm"}, {}}};
  EXPECT_EQ(find_axis_columns(data, {"q2", "", ""})->measured, "y");
  EXPECT_EQ(find_axis_columns(data, {"y", "", ""})->target, "q2_cmd");
  data.columns.push_back({{"y_target", "mm"}, {}});
  EXPECT_EQ(find_axis_columns(data, {"q2", "", ""})->target, "y_target");
  EXPECT_EQ(find_axis_columns(data, {"q1", "", ""}).error().reason, "NO_COLUMN");
  EXPECT_EQ(find_axis_columns(data, {"q7", "", ""}).error().reason, "BAD_AXIS");
}

TEST(AxisColumns, OfOneOfSeveralRobotsAreNeverThoseOfAnother) {
  Dataset data;
  for (const char* symbol : {"mn.q3", "ma.q3", "q3_cmd", "q6_cmd", "ma.z"})
    data.columns.push_back({{symbol, "mm"}, {}});
  for (const char* axis : {"q3", "ma.q3"}) {
    const auto refused = find_axis_columns(data, {axis, "", "ma.z"});
    ASSERT_FALSE(refused) << axis << " was wanted by " << refused->target;
    EXPECT_EQ(refused.error().reason, "NO_COLUMN");
  }
  EXPECT_EQ(find_axis_columns(data, {"q3", "q6_cmd", "ma.z"})->target, "q6_cmd");
  data.columns.push_back({{"ma.z_target", "mm"}, {}});
  const auto by_pose = find_axis_columns(data, {"ma.q3", "", ""});
  EXPECT_EQ(by_pose->target, "ma.z_target");
  EXPECT_EQ(by_pose->measured, "ma.z");
}

// mn's third motor rests at 0 while ma's moves.
TEST(Approaches, OfOneOfSeveralRobotsAreReadOffTheCommandThatIsNamed) {
  Dataset data = visits_of({{0, 0}, {-4, 0}, {4, 0}});
  data.columns[0].channel.symbol = "q6_cmd";
  data.columns[1].channel.symbol = "ma.z";
  data.columns.push_back({{"q3_cmd", "mm"}, {0, 0, 0}});
  data.columns.push_back({{"ma.q3", "mm"}, {0, -4, 4}});
  data.columns.push_back({{"mn.q3", "mm"}, {0, 0, 0}});
  const auto approaches = approaches_of(data, {"q3", "q6_cmd", "ma.z"});
  EXPECT_EQ(approaches->at(1).side, ApproachSide::down);
  EXPECT_EQ(approaches->at(2).side, ApproachSide::up);
}

}  // namespace
}  // namespace driftwise::standards
