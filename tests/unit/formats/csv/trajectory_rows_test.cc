#include "server/formats/csv/trajectory_rows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/core/data/row_marks.h"

namespace driftwise::formats {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Dataset rows_with_a_passage() {
  Dataset data;
  data.rows = 6;
  data.excluded = {kInUse, kInUse, kPassageRow, kInUse, kSuspectRow, kInUse};
  return data;
}

TEST(TrajectoryRows, AreCountedWithoutPassagesWhereNothingElseIsSaid) {
  EXPECT_THAT(*trajectory_rows(rows_with_a_passage(), "a.csv"), ElementsAre(1, 2, 3, 4, 5));
}

TEST(TrajectoryRows, ComeBackInTheOrderOfTheFile) {
  auto data = rows_with_a_passage();
  set_trajectory_rows(data, {1, 3, 4, 2, 9});
  ASSERT_EQ(data.metadata.size(), 1U);
  EXPECT_EQ(data.metadata[0].second, "1,3-4,2,9");
  EXPECT_THAT(*trajectory_rows(data, "a.csv"), ElementsAre(1, 3, 4, 2, 9));
  set_trajectory_rows(data, {1, 2, 3, 4, 5});
  EXPECT_THAT(data.metadata, IsEmpty()) << "as they are counted anyway";
}

TEST(TrajectoryRows, OfAFileThatWasCutAreRefused) {
  auto data = rows_with_a_passage();
  data.metadata = {{"trajectory_rows", "1-3,7"}};
  const auto cut = trajectory_rows(data, "a.csv");
  ASSERT_FALSE(cut);
  EXPECT_EQ(cut.error().reason, "BAD_ROWS");
  EXPECT_THAT(cut.error().message, HasSubstr("a.csv: the line # trajectory_rows names 4 rows, "
                                             "found 5 rows of the trajectory"));
  data.metadata = {{"trajectory_rows", "1-3,a"}};
  EXPECT_EQ(trajectory_rows(data, "a.csv").error().reason, "BAD_ROWS");
}

}  // namespace
}  // namespace driftwise::formats
