#include "server/core/data/overruns.h"

#include <gtest/gtest.h>

namespace driftwise {
namespace {

// q1 goes up, rests, and goes down again, over and over: it turns once in four rows.
Dataset up_and_down(std::size_t rows) {
  constexpr double kPlaces_mm[] = {0, 1, 1, 0};
  Dataset data;
  data.rows = rows;
  data.columns = {{{"q1", "mm"}, {}}, {{"q2", "mm"}, {}}, {{"t01", "degC"}, {}}};
  for (std::size_t row = 0; row < rows; ++row) {
    data.time_s.push_back(static_cast<double>(row));
    data.columns[0].values.push_back(kPlaces_mm[row % 4]);
    data.columns[1].values.push_back(0);
    data.columns[2].values.push_back(20 + 0.1 * static_cast<double>(row));
  }
  return data;
}

TEST(Overruns, StandBeforeTheRowsWhereACoordinateTurns) {
  const auto whole = with_overruns(up_and_down(6));
  // Rows 0 (the start: from short of it), 2 (after going up) and 4 (after going down).
  EXPECT_EQ(whole.kept, (std::vector<std::size_t>{1, 2, 4, 5, 7, 8}));
  EXPECT_EQ(whole.data.rows, 9u);
  EXPECT_EQ(whole.data.time_s, (std::vector<double>{0, 0, 1, 2, 2, 3, 4, 4, 5}));
  EXPECT_EQ(whole.data.columns[0].values, (std::vector<double>{-0.5, 0, 1, 1.5, 1, 0, -0.5, 0, 1}));
  EXPECT_EQ(whole.data.columns[2].values[3], whole.data.columns[2].values[4]);
}

// Each column is copied once: with an insertion for each turn this took a minute.
TEST(Overruns, OfAHundredThousandRowsAreOneCopyOfEachColumn) {
  const std::size_t rows = 100'000;
  const auto whole = with_overruns(up_and_down(rows));
  EXPECT_EQ(whole.kept.size(), rows);
  EXPECT_GT(whole.data.rows, rows + rows / 3);
  for (const auto& column : whole.data.columns) EXPECT_EQ(column.values.size(), whole.data.rows);
}

}  // namespace
}  // namespace driftwise
