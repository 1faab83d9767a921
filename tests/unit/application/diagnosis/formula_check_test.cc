#include "server/application/models/formula_check.h"

#include <gmock/gmock.h>

namespace driftwise::application {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// x takes three values, so x^3 is x on them; t07 follows nothing.
Dataset three_values() {
  Dataset data;
  data.rows = 60;
  DatasetColumn x{{"x", "mm"}, {}}, t07{{"t07", "degC"}, {}}, q1{{"q1", "mm"}, {}};
  for (int row = 0; row < 60; ++row) {
    x.values.push_back(row % 3 - 1);
    t07.values.push_back(20 + 0.01 * (row * row % 17));
    q1.values.push_back(x.values.back() + 1e-5 * (row * 7 % 5));
    data.set.push_back(row % 10 == 9 ? PointSet::validation : PointSet::calibration);
  }
  data.columns = {x, t07, q1};
  return data;
}

FormulaCheck check_of(const std::string& formula) {
  FitRequest request;
  request.formula = formula;
  return check_formula_on(three_values(), request);
}

TEST(FormulaCheck, CountsTermsRowsAndRank) {
  const auto check = check_of("q ~ x + x^2 + T");
  EXPECT_EQ(check.problem, "");
  EXPECT_THAT(check.outputs, ElementsAre("q1"));
  EXPECT_THAT(check.terms, ElementsAre("x", "x^2", "t07"));
  EXPECT_EQ(check.calibration, 54);
  EXPECT_EQ(check.validation, 6);
  EXPECT_EQ(check.columns, 4) << "the constant with them";
  EXPECT_EQ(check.rank, 4);
  EXPECT_THAT(check.look_alikes, IsEmpty());
}

TEST(FormulaCheck, NamesWhatTheRowsCannotTellApart) {
  const auto check = check_of("q ~ x + x^2 + x^3");
  EXPECT_EQ(check.problem, "") << "stepwise can choose among them";
  EXPECT_EQ(check.rank, 3);
  EXPECT_THAT(check.look_alikes, ElementsAre("x and x^3 cannot be told apart on these rows"));
}

TEST(FormulaCheck, MarksThePlaceOfATypoAndStillSaysWhatThereIs) {
  const auto check = check_of("q ~ x + to7");
  EXPECT_THAT(check.problem, HasSubstr("to7"));
  ASSERT_TRUE(check.problem_offset);
  EXPECT_EQ(*check.problem_offset, 8u);
  EXPECT_EQ(check.channels.size(), 3u);
  EXPECT_EQ(check_of("q ~ x + ").problem_offset, 8u) << "at the end, where something is missing";
}

TEST(FormulaCheck, RefusesWhatTheFitRefuses) {
  EXPECT_THAT(check_of("q ~ x - 1").problem, HasSubstr("only with --select all"));
  EXPECT_THAT(check_of("q ~ x - 1").terms, ElementsAre("x"));
  FitRequest all;
  all.formula = "q ~ x - 1";
  all.select = "all";
  EXPECT_EQ(check_formula_on(three_values(), all).problem, "");
}

TEST(FormulaCheck, TakesAnythingThatIsTyped) {
  for (const char* text :
       {"", "~", "q", "q ~", "q ~ ((((", "q ~ lag(", "q ~ x^99", "q ~ x\n+ y", "\xff"})
    EXPECT_NE(check_of(text).problem, "") << text;
}

}  // namespace
}  // namespace driftwise::application
