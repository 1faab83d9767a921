// Rows that lack a condition's value: a scanner that does not answer at every row, a load cell that
// fell out for an hour.

#include "server/diagnosis/rows/missing_values.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/core/data/reading.h"
#include "server/diagnosis/diagnose.h"
#include "server/formats/formula/formula.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::size_t kGapRows = 120;
constexpr double kGapStep_s = 60;

// q1 follows x, the part that t01 is on (200 nm/K) and the load (40 nm/N); 3 nm of noise.
Dataset loaded_and_warm() {
  std::mt19937_64 random(31);
  std::normal_distribution<double> normal;
  Dataset data;
  data.rows = kGapRows;
  data.columns = {
      {{"q1", "mm"}, {}}, {{"x", "mm"}, {}}, {{"t01", "degC"}, {}}, {{"force", "N"}, {}}};
  for (std::size_t row = 0; row < kGapRows; ++row) {
    const double t_s = kGapStep_s * static_cast<double>(row), part_k = 0.5 * std::sin(t_s / 2000);
    const double at_mm = static_cast<double>(random() % 31) * 0.1,
                 force_n = static_cast<double>(random() % 4);
    data.time_s.push_back(t_s);
    data.columns[0].values.push_back(at_mm +
                                     1e-6 * (200 * part_k + 40 * force_n + 3 * normal(random)));
    data.columns[1].values.push_back(at_mm);
    data.columns[2].values.push_back(20 + part_k);
    data.columns[3].values.push_back(force_n);
  }
  return data;
}

TEST(MissingValues, OfATemperatureLieOnTheLineBetweenItsReadings) {
  Dataset data = loaded_and_warm();
  auto& t01 = data.columns[2].values;
  const auto whole = t01;
  for (std::size_t row = 0; row < kGapRows; ++row)
    if (row % 9 != 0) t01[row] = kMissing;
  const auto closed = without_gaps(data, {"t01", "force"});
  // Of 0.5 K in 2000 s / rad the curve between readings 540 s apart is (540 / 2000)^2 / 8 x 0.5 K.
  for (std::size_t row = 0; row < kGapRows - 3; ++row)
    EXPECT_NEAR(closed.data.columns[2].values[row], whole[row], 0.005) << row;
  EXPECT_TRUE(closed.data.excluded.empty());
  EXPECT_THAT(closed.sentences,
              testing::ElementsAre("106 of 120 rows have no value of t01: taken from the readings "
                                   "before and after, along a straight line in time"));
}

TEST(MissingValues, OfALoadLeaveTheirRowsOut) {
  Dataset data = loaded_and_warm();
  for (std::size_t row = 40; row < 60; ++row) data.columns[3].values[row] = kMissing;
  const auto closed = without_gaps(data, {"t01", "force"});
  ASSERT_EQ(closed.data.excluded.size(), kGapRows);
  for (std::size_t row = 0; row < kGapRows; ++row)
    EXPECT_EQ(closed.data.is_excluded(row), row >= 40 && row < 60) << row;
  EXPECT_THAT(closed.unread, testing::IsEmpty());
}

TEST(MissingValues, OfMoreRowsThanCanBeSparedLeaveTheChannelOut) {
  Dataset data = loaded_and_warm();
  for (std::size_t row = 40; row < 90; ++row)
    data.columns[2].values[row] = data.columns[3].values[row] = kMissing;
  const auto closed = without_gaps(data, {"t01", "force"});
  EXPECT_THAT(closed.unread, testing::ElementsAre("t01", "force"));
  EXPECT_TRUE(closed.data.excluded.empty());
}

// As of an export that was pasted twice, without its times.
TEST(RowsThatAreThereTwice, CountOnce) {
  const Dataset once = loaded_and_warm();
  Dataset twice = once;
  twice.rows = 2 * kGapRows;
  twice.time_s.clear();
  for (auto& column : twice.columns)
    column.values.insert(column.values.end(), column.values.begin(), column.values.end());
  const auto whole = without_gaps(twice, {"t01", "force"});
  ASSERT_EQ(std::ranges::count(whole.data.excluded, 1), kGapRows);
  EXPECT_EQ(std::count(whole.data.excluded.begin(), whole.data.excluded.begin() + kGapRows, 1), 0);
  EXPECT_THAT(whole.sentences, testing::ElementsAre(testing::HasSubstr(
                                   "120 of 240 rows repeat an earlier row in every value")));
}

TEST(RowsThatAreThereTwice, AreMeasurementsWhereReadingsAreCoarse) {
  Dataset coarse = loaded_and_warm();
  coarse.time_s.clear();
  for (auto& column : coarse.columns)
    for (double& value : column.values) value = std::round(value);
  EXPECT_TRUE(without_gaps(coarse, {"t01", "force"}).data.excluded.empty());
}

// A logger that asks five times while the instruments read once: four rows in five say nothing new,
// whatever their times.
TEST(RowsThatAreThereTwice, CountOnceWhereALoggerAsksFasterThanTheInstrumentsRead) {
  const Dataset once = loaded_and_warm();
  Dataset asked = once;
  asked.rows = 5 * kGapRows;
  asked.time_s.clear();
  for (auto& column : asked.columns) column.values.clear();
  for (std::size_t row = 0; row < asked.rows; ++row) {
    asked.time_s.push_back(once.time_s[row / 5] + static_cast<double>(row % 5));
    for (std::size_t c = 0; c < once.columns.size(); ++c)
      asked.columns[c].values.push_back(once.columns[c].values[row / 5]);
  }
  const auto whole = without_gaps(asked, {"t01", "force"});
  ASSERT_EQ(whole.data.excluded.size(), asked.rows);
  for (std::size_t row = 0; row < asked.rows; ++row)
    EXPECT_EQ(whole.data.is_excluded(row), row % 5 != 0) << row;
  EXPECT_THAT(whole.sentences, testing::ElementsAre(testing::HasSubstr(
                                   "480 of 600 rows repeat the row before in every value")));
  EXPECT_TRUE(without_gaps(once, {"t01", "force"}).data.excluded.empty());
}

// A machine at rest before a display of a micrometre: the same number again is a measurement.
TEST(RowsThatAreThereTwice, AreMeasurementsOfADisplayThatStandsStill) {
  Dataset still = loaded_and_warm();
  for (auto& column : still.columns)
    for (double& value : column.values) value = std::round(value);
  EXPECT_TRUE(without_gaps(still, {"t01", "force"}).data.excluded.empty());
}

TEST(MissingValues, HideNoCause) {
  Dataset data = loaded_and_warm();
  for (std::size_t row = 0; row < kGapRows; ++row) {
    if (row % 9 == 0) data.columns[2].values[row] = kMissing;
    if (row % 13 == 5) data.columns[3].values[row] = kMissing;
  }
  DiagnoseOptions options;
  options.baseline = *formats::Formula::parse("q1 ~ x + x^2")->expand(data);
  const auto found = diagnose(data, options);
  ASSERT_TRUE(found) << found.error().message;
  std::vector<std::string> causes;
  for (const auto& finding : found->findings) causes.push_back(finding.cause);
  EXPECT_THAT(causes, testing::UnorderedElementsAre("thermal_offset", "force_compliance"));
  EXPECT_EQ(found->verdict, Verdict::extended);
}

TEST(MissingValues, AllRowsForValidationAreSearchedAndSaid) {
  Dataset data = loaded_and_warm();
  data.set.assign(kGapRows, PointSet::validation);
  DiagnoseOptions options;
  options.baseline = *formats::Formula::parse("q1 ~ x + t01 + F")->expand(data);
  const auto found = diagnose(data, options);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_THAT(found->warnings,
              testing::Contains(testing::StartsWith("every row is marked for validation")));
  for (const auto& one : found->not_testable)
    EXPECT_THAT(one.why, testing::Not(testing::HasSubstr("fewer than")));
}

}  // namespace
}  // namespace driftwise::diagnosis
