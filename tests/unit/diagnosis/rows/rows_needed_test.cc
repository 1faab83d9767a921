// Data with too few rows to learn from: the refusal says where the others are.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "server/core/data/reading.h"
#include "server/core/data/row_marks.h"
#include "server/diagnosis/rows/problem.h"
#include "server/formats/formula/formula.h"

namespace driftwise::diagnosis {
namespace {

Dataset rows_of_x_and_t01(std::size_t rows) {
  Dataset data;
  data.rows = rows;
  data.columns = {{{"ex", "mm"}, {}}, {{"x", "mm"}, {}}, {{"t01", "degC"}, {}}};
  for (std::size_t row = 0; row < rows; ++row) {
    data.time_s.push_back(20.0 * static_cast<double>(row));
    data.columns[0].values.push_back(1e-5 * static_cast<double>(row * row % 17));
    data.columns[1].values.push_back(static_cast<double>(row * 7 % 16));
    data.columns[2].values.push_back(20 + 0.1 * static_cast<double>(row * 5 % 11));
  }
  return data;
}

struct TooFew {
  const char* name;
  std::size_t rows;
  std::function<void(Dataset&)> spoil;
  const char* says;
};
class RowsNeeded : public testing::TestWithParam<TooFew> {};
TEST_P(RowsNeeded, AreRefusedWithTheRowsThatTeachNothing) {
  Dataset data = rows_of_x_and_t01(GetParam().rows);
  GetParam().spoil(data);
  const auto baseline = formats::Formula::parse("ex ~ x + x^2 + t01")->expand(data);
  const auto problem = lay_out(data, *baseline, kMostSearched);
  ASSERT_FALSE(problem);
  EXPECT_EQ(problem.error().reason, "TOO_FEW_ROWS");
  EXPECT_THAT(problem.error().message, testing::HasSubstr(GetParam().says));
}
INSTANTIATE_TEST_SUITE_P(
    Table, RowsNeeded,
    testing::Values(
        TooFew{"OneRow", 1, [](Dataset&) {},
               "a diagnosis of this baseline needs 14 rows to learn from, and finds 1 in data of 1 "
               "row: measure more, or leave terms out of the baseline"},
        TooFew{"EmptyThermometer", 60,
               [](Dataset& data) { data.columns[2].values.assign(60, kMissing); },
               "finds 0 in data of 60 rows: t01 has no value in 60 rows: leave it out of the "
               "baseline, or measure it"},
        TooFew{"EmptyOutput", 60,
               [](Dataset& data) { data.columns[0].values.assign(60, kMissing); },
               "ex has no value in 60 rows: measure it, or name another output"},
        TooFew{"Validation", 60,
               [](Dataset& data) {
                 data.set.assign(60, PointSet::validation);
                 std::fill_n(data.set.begin(), 5, PointSet::calibration);
               },
               "finds 5 in data of 60 rows: 55 rows are marked validation and only judge: mark "
               "rows to learn from as calibration in column set"},
        TooFew{"Excluded", 60, [](Dataset& data) { data.excluded.assign(60, 1); },
               "60 rows are left out (marked excluded, the same as an earlier row, or without a "
               "value of a condition): take back the marks that are wrong"},
        TooFew{"RowsBetweenPassages", 24,
               [](Dataset& data) {
                 data.excluded.assign(24, 0);
                 for (std::size_t row = 0; row < 24; row += 2) data.excluded[row] = kPassageRow;
               },
               "finds 12 in data of 12 rows: measure more, or leave terms out of the baseline"},
        TooFew{"ExcludedAndEmpty", 20,
               [](Dataset& data) {
                 data.excluded.assign(20, 0);
                 data.excluded[0] = 1;
                 std::fill_n(data.columns[2].values.begin(), 9, kMissing);
               },
               "1 row is left out (marked excluded, the same as an earlier row, or without a value "
               "of a condition): take back the marks that are wrong; t01 has no value in 8 rows"}),
    [](const auto& row) { return std::string(row.param.name); });

}  // namespace
}  // namespace driftwise::diagnosis
