// What a diagnosis makes of data that it cannot be asked everything of, or nothing.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "server/core/try.h"
#include "server/diagnosis/diagnose.h"
#include "server/formats/formula/formula.h"
#include "tests/hidden_effects/shapes/hidden_world.h"

namespace driftwise::hidden {
namespace {

using testing::HasSubstr;

Result<diagnosis::Diagnosis> asked(const Dataset& data, const std::string& baseline) {
  const auto formula = formats::Formula::parse(baseline);
  DRIFTWISE_TRY(const auto candidates, formula->expand(data));
  diagnosis::DiagnoseOptions options;
  options.baseline = candidates;
  options.nulls = 99;
  return diagnosis::diagnose(data, options);
}

HiddenData typical() { return make({}, {{"geometry_order", 0, 300}}, 11); }

bool names(const diagnosis::Diagnosis& found, const std::string& cause) {
  return std::ranges::any_of(
      found.findings, [&](const diagnosis::Finding& finding) { return finding.cause == cause; });
}

std::string why_not(const diagnosis::Diagnosis& found, const std::string& cause) {
  for (const auto& one : found.not_testable)
    if (one.cause == cause) return one.why;
  return "";
}

TEST(BadInput, TimeThatRunsBackwardsIsNamedWithItsRow) {
  auto made = typical();
  std::swap(made.data.time_s[100], made.data.time_s[101]);
  const auto found = asked(made.data, made.baseline);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().reason, "TIME_RUNS_BACK");
  EXPECT_THAT(found.error().message, HasSubstr("row 102"));
}

TEST(BadInput, ABaselineThatDoesNotFitNamesTheChannel) {
  const auto made = typical();
  const auto found = asked(made.data, "q1 ~ x + t99");
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().message, HasSubstr("t99"));
}

TEST(BadInput, TwoRowsAreTooFew) {
  auto made = typical();
  Dataset two = made.data;
  two.rows = 2;
  two.time_s.resize(2);
  two.dwell_s.resize(2);
  two.set.clear();
  for (auto& column : two.columns) column.values.resize(2);
  const auto found = asked(two, made.baseline);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().reason, "TOO_FEW_ROWS");
}

TEST(BadInput, OnlyZerosHaveNothingToExplain) {
  auto made = typical();
  std::ranges::fill(made.data.columns.front().values, 0.0);
  const auto found = asked(made.data, made.baseline);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().reason, "NOTHING_VARIES");
  EXPECT_THAT(found.error().message, HasSubstr("q1_mm"));
}

TEST(BadInput, WithoutTimeWhatNeedsNoTimeIsStillFound) {
  auto made = typical();
  made.data.time_s.clear();
  const auto found = asked(made.data, made.baseline);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_TRUE(names(*found, "geometry_order"));
  EXPECT_THAT(why_not(*found, "thermal_lag"), HasSubstr("time_s"));
  EXPECT_THAT(why_not(*found, "step_change"), HasSubstr("time_s"));
}

TEST(BadInput, OneSetOnlyIsJudgedByBlocksOfTime) {
  auto made = typical();
  made.data.set.clear();
  const auto found = asked(made.data, made.baseline);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_TRUE(names(*found, "geometry_order"));
  EXPECT_GT(found->rows_held_out, 0U);
  EXPECT_THAT(found->warnings, testing::Contains(HasSubstr("no validation set")));
}

TEST(BadInput, MissingChannelsAreListedWithWhatTheyWouldTest) {
  auto made = typical();
  std::erase_if(made.data.columns,
                [](const DatasetColumn& column) { return column.channel.symbol.starts_with("r"); });
  const auto found = asked(made.data, made.baseline);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_THAT(why_not(*found, "force_compliance"), HasSubstr("force_N"));
  EXPECT_THAT(why_not(*found, "abbe_offset"), HasSubstr("tilt"));
}

TEST(BadInput, CancelEndsIt) {
  const auto made = typical();
  diagnosis::DiagnoseOptions options;
  options.baseline = *formats::Formula::parse(made.baseline)->expand(made.data);
  int calls = 0;
  double last = 0;
  options.progress = [&](double fraction, const std::string&) {
    EXPECT_GE(fraction, last);
    last = fraction;
    return ++calls < 20;
  };
  const auto found = diagnosis::diagnose(made.data, options);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::cancelled);
  EXPECT_EQ(calls, 20);
}

}  // namespace
}  // namespace driftwise::hidden
