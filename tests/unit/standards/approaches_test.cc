#include "server/standards/approaches.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
              testing::ElementsAre(unknown, up, unknown, down, up));
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

}  // namespace
}  // namespace driftwise::standards
