#include "server/identification/folds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>

namespace driftwise::identification {
namespace {

std::vector<std::size_t> first_rows(std::size_t count) {
  std::vector<std::size_t> rows(count);
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  return rows;
}

TEST(TimeFolds, HoldOutEveryRowOnceWithAGapOnEitherSide) {
  const auto folds = time_folds(first_rows(100), 5, 0.25);
  ASSERT_EQ(folds.size(), 5U);
  std::set<std::size_t> held;
  for (const auto& fold : folds) {
    EXPECT_EQ(fold.test.size(), 20U);
    held.insert(fold.test.begin(), fold.test.end());
    for (const std::size_t row : fold.train) {
      EXPECT_TRUE(row + 5 < fold.test.front() || row > fold.test.back() + 5) << row;
    }
  }
  EXPECT_EQ(held.size(), 100U);
  EXPECT_EQ(folds[0].train.size(), 75U);
  EXPECT_EQ(folds[2].train.size(), 70U);
}

TEST(TimeFolds, AreNoneForTooFewRows) {
  EXPECT_TRUE(time_folds(first_rows(29), 10, 0.25).empty());
  EXPECT_TRUE(time_folds(first_rows(29), 1, 0.25).empty());
}

Dataset grouped() {
  Dataset data;
  data.rows = 12;
  data.line = {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3};
  data.columns.push_back({{"goal", "mm"}, {1, 1, 2, 2, 1, 1, 2, 2, 1, 1, 2, 2}});
  return data;
}

TEST(GroupFolds, NeverSplitAGroup) {
  const Dataset data = grouped();
  const auto labels = group_labels(data, "line");
  ASSERT_TRUE(labels);
  const auto folds = group_folds(first_rows(12), *labels, 2);
  ASSERT_EQ(folds.size(), 2U);
  for (const auto& fold : folds) {
    EXPECT_EQ(fold.train.size() + fold.test.size(), 12U);
    for (const std::size_t test : fold.test)
      for (const std::size_t train : fold.train) EXPECT_NE((*labels)[test], (*labels)[train]);
  }
}

TEST(GroupLabels, AgreeWhereAllChannelsDo) {
  const auto labels = group_labels(grouped(), "goal");
  ASSERT_TRUE(labels);
  EXPECT_EQ(std::set<int>(labels->begin(), labels->end()).size(), 2U);
}

TEST(GroupLabels, NameTheChannelThatIsNotThere) {
  const auto labels = group_labels(grouped(), "goal,target");
  ASSERT_FALSE(labels);
  EXPECT_NE(labels.error().message.find("'target', the data have: line goal"), std::string::npos)
      << labels.error().message;
  Dataset no_lines = grouped();
  no_lines.line.clear();
  EXPECT_EQ(group_labels(no_lines, "line").error().reason, "NO_LINES");
}

TEST(GroupFolds, AreNoneWithFewerGroupsThanFolds) {
  const auto labels = group_labels(grouped(), "goal");
  EXPECT_TRUE(group_folds(first_rows(12), *labels, 3).empty());
}

}  // namespace
}  // namespace driftwise::identification
