// Every bad input has its sentence.

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>

#include "server/calibration/design/predict.h"
#include "server/core/data/reading.h"
#include "server/formats/formula/formula.h"
#include "tests/unit/calibration/campaign.h"

namespace driftwise::calibration {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;

Error error_of(const Dataset& data, const std::string& formula, const FitOptions& options = {}) {
  const auto model = formats::fit_formula(data, formula, options);
  EXPECT_FALSE(model.has_value());
  return model ? Error{} : model.error();
}

FitOptions all_terms() {
  FitOptions options;
  options.select = Select::all;
  return options;
}

TEST(FitErrors, NamesAConstantThermometer) {
  Dataset data = make_campaign({});
  for (auto& value : data.columns[4].values) value = 23;
  const Error error = error_of(data, "q1 ~ x + T", all_terms());
  EXPECT_EQ(error.reason, "RANK_DEFICIENT");
  EXPECT_THAT(error.message, HasSubstr("t03 is constant at 23"));
}

TEST(FitErrors, NamesTermsThatEqualOneAnother) {
  Dataset data = make_campaign({});
  data.columns.push_back({{"y", "mm"}, data.columns[1].values});
  for (auto& value : data.columns.back().values) value = -value;  // y = -x: y^2 = x^2
  const Error error = error_of(data, "q1 ~ x + x^2 + y^2", all_terms());
  EXPECT_EQ(error.reason, "RANK_DEFICIENT");
  EXPECT_THAT(error.message, HasSubstr("x^2 and y^2 cannot be told apart on these rows"));
}

TEST(FitErrors, NamesASumOfOthers) {
  Dataset data = make_campaign({});
  auto sum = data.columns[2].values;
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += data.columns[3].values[i];
  data.columns.push_back({{"t09", "degC"}, sum});
  EXPECT_THAT(error_of(data, "q1 ~ x + T", all_terms()).message,
              HasSubstr("t09 cannot be told apart from t01, t02"));
}

// Rows at x = middle +- 0.5 mm with a fifth-degree law in x - middle and 5 nm of noise.
Dataset far_from_zero(double middle_mm) {
  Dataset data;
  data.rows = 200;
  data.columns = {{{"x", "mm"}, {}}, {{"q1", "mm"}, {}}};
  std::uint32_t state = 7;
  const auto uniform = [&state] {
    state = state * 1664525u + 1013904223u;
    return state / 4294967296.0 - 0.5;
  };
  for (std::size_t i = 0; i < data.rows; ++i) {
    const double u = uniform();
    data.columns[0].values.push_back(middle_mm + u);
    data.columns[1].values.push_back(u + 1e-3 * u * u - 2e-4 * std::pow(u, 5) + 1.7e-5 * uniform());
  }
  return data;
}

TEST(FitErrors, RefusesAModelThatLosesItsDigitsInTheFormItIsServedIn) {
  for (const double middle_mm : {2000.0, 1e9}) {
    const Error error = error_of(far_from_zero(middle_mm), "q1 ~ poly(x,5)", all_terms());
    EXPECT_EQ(error.reason, "DIGITS_LOST") << middle_mm;
    EXPECT_THAT(error.message, AllOf(HasSubstr("q1: the fit leaves "), HasSubstr("x lies at "),
                                     HasSubstr("take an offset of about ")));
  }
  for (const double middle_mm : {0.0, 10.0}) {
    const auto model =
        formats::fit_formula(far_from_zero(middle_mm), "q1 ~ poly(x,5)", all_terms());
    ASSERT_TRUE(model.has_value()) << model.error().message;
    const auto& accuracy = model->outputs[0].accuracy;
    EXPECT_LT(accuracy.a90_calibration, 1.2 * *accuracy.a90_blocks) << middle_mm;
    EXPECT_GT(accuracy.a90_calibration, 0.8 * *accuracy.a90_blocks) << middle_mm;
  }
}

TEST(FitErrors, StepwiseLeavesOutWhatCannotBeToldApartAndSaysSo) {
  Dataset data = make_campaign({});
  data.columns.push_back({{"t08", "degC"}, data.columns[2].values});  // a copy of t01
  const auto model = formats::fit_formula(data, "q1 ~ x + x^2 + T", {});
  ASSERT_TRUE(model.has_value());
  EXPECT_THAT(model->warnings,
              Contains(HasSubstr("t01 and t08 cannot be told apart on these rows")));
}

TEST(FitErrors, WarnsOfAThermometerThatHardlyMoves) {
  Dataset data = make_campaign({});
  for (std::size_t i = 0; i < data.rows; ++i)
    data.columns[4].values[i] = 23 + (i % 2 == 0 ? 1e-4 : -1e-4);
  const auto model = formats::fit_formula(data, "q1 ~ x + x^2 + T", {});
  ASSERT_TRUE(model.has_value());
  EXPECT_THAT(model->warnings, Contains(HasSubstr("t03 is constant within 0.2 mK")));
}

TEST(FitErrors, RefusesTooFewRows) {
  const Error error = error_of(make_campaign({.rows = 6}), "q1 ~ x + T", all_terms());
  EXPECT_EQ(error.reason, "TOO_FEW_ROWS");
  EXPECT_THAT(error.message,
              AllOf(HasSubstr("4 complete calibration rows"), HasSubstr("at least 7")));
}

TEST(FitErrors, NamesTheChannelThatIsMissingInMostRows) {
  Dataset data = make_campaign({.rows = 30});
  for (double& value : data.columns[3].values) value = kMissing;  // t02
  data.columns[2].values[0] = kMissing;
  const Error error = error_of(data, "q1 ~ x + T");
  EXPECT_EQ(error.reason, "TOO_FEW_ROWS");
  EXPECT_THAT(error.message, AllOf(HasSubstr("0 complete calibration rows"),
                                   HasSubstr("t02 has no value in 20 of 20 calibration rows"),
                                   HasSubstr("leave it out of the formula")));
}

TEST(FitErrors, SaysThatEveryRowIsMarkedValidation) {
  Dataset data = make_campaign({.rows = 30});
  data.set.assign(data.rows, PointSet::validation);
  const Error error = error_of(data, "q1 ~ x + T");
  EXPECT_EQ(error.reason, "TOO_FEW_ROWS");
  EXPECT_THAT(error.message, HasSubstr("every row is marked validation"));
}

TEST(FitErrors, SaysOnceOfAConstantThermometerThatItTellsNothing) {
  Dataset data = make_campaign({});
  for (double& value : data.columns[4].values) value = 23;  // t03
  const auto model = formats::fit_formula(data, "q1 ~ x + x^2 + T", {});
  ASSERT_TRUE(model.has_value());
  EXPECT_EQ(std::ranges::count_if(model->warnings,
                                  [](const auto& warning) {
                                    return warning.find("t03 is constant") != std::string::npos;
                                  }),
            1)
      << testing::PrintToString(model->warnings);
}

// It would be a perfect model.
TEST(FitErrors, RefusesAForcedTermThatIsTheOutputItself) {
  for (const bool with_product : {false, true}) {
    FitOptions options;
    options.forced.push_back({{effects::Power{"q1", 1}}});
    if (with_product) options.forced[0].factors.push_back(effects::Power{"t01", 1});
    const Error error = error_of(make_campaign({}), "q1 ~ x + T", options);
    EXPECT_EQ(error.reason, "BAD_OPTIONS");
    EXPECT_THAT(error.message, HasSubstr("the output q1 stands among its own terms"));
  }
}

// A run that holds such rows from before they were rejected can be fitted; the rows are named.
TEST(FitErrors, TakesWhatCannotHaveBeenMeasuredAsMissing) {
  Dataset data = make_campaign({});
  Dataset without = data;
  data.columns[2].values[4] = std::numeric_limits<double>::infinity();
  data.columns[1].values[7] = 1e308;
  without.columns[2].values[4] = without.columns[1].values[7] = kMissing;
  const auto model = formats::fit_formula(data, "q1 ~ x + T", {});
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_THAT(model->warnings, Contains(AllOf(HasSubstr("2 rows hold"), HasSubstr("row 5: t01"),
                                              HasSubstr("row 8"))));
  const auto same = formats::fit_formula(without, "q1 ~ x + T", {});
  ASSERT_TRUE(same) << same.error().message;
  EXPECT_EQ(model->outputs[0].coefficients, same->outputs[0].coefficients);
}

TEST(FitErrors, RefusesThresholdsThatWouldCycle) {
  FitOptions options;
  options.p_enter = 0.1;
  options.p_remove = 0.05;
  EXPECT_THAT(error_of(make_campaign({}), "q1 ~ x", options).message,
              HasSubstr("p_remove 0.05 is below p_enter 0.1"));
  options.p_remove = 2;
  EXPECT_EQ(error_of(make_campaign({}), "q1 ~ x", options).reason, "BAD_OPTIONS");
}

TEST(FitErrors, RefusesStepwiseWithoutAConstant) {
  EXPECT_THAT(error_of(make_campaign({}), "q1 ~ x - 1").message, HasSubstr("select all"));
}

TEST(FitErrors, RefusesADerivativeOfUntimedData) {
  Dataset data = make_campaign({});
  data.time_s.clear();
  EXPECT_EQ(error_of(data, "q1 ~ x + rate(t01, 300 s)").reason, "UNTIMED");
}

TEST(FitErrors, AFunctionOfThePlaceAsksForNoTimes) {
  Dataset data = make_campaign({});
  const auto timed = formats::fit_formula(data, "q1 ~ x + sin(x, 900000 nm) + T", all_terms());
  data.time_s.clear();
  const auto untimed = formats::fit_formula(data, "q1 ~ x + sin(x, 900000 nm) + T", all_terms());
  ASSERT_TRUE(timed) << timed.error().message;
  ASSERT_TRUE(untimed) << untimed.error().message;
  EXPECT_EQ(untimed->outputs[0].coefficients, timed->outputs[0].coefficients);
  EXPECT_TRUE(predict(data, untimed->outputs[0]));
}

TEST(FitErrors, RefusesANegativeWeight) {
  Dataset data = make_campaign({});
  data.columns.push_back({{"w", "1"}, std::vector<double>(data.rows, 1)});
  data.columns.back().values[7] = -1;
  FitOptions options;
  options.weight_symbol = "w";
  EXPECT_THAT(error_of(data, "q1 ~ x", options).message,
              AllOf(HasSubstr("row 8"), HasSubstr("weight w is -1")));
}

TEST(FitErrors, SurvivesValuesAtTheEdgeOfDoublePrecision) {
  Dataset data = make_campaign({});
  for (auto& value : data.columns[1].values) value *= 1e29;
  EXPECT_EQ(error_of(data, "q1 ~ x + x^12").reason, "BAD_VALUE");
  for (auto& value : data.columns[1].values) value *= 1e10;
  const Error error = error_of(data, "q1 ~ x + x^4");
  EXPECT_EQ(error.reason, "TOO_FEW_ROWS");
  EXPECT_THAT(error.message, HasSubstr("values that no instrument can have measured"));
}

TEST(FitErrors, FitsAnExactLineWithoutFittingItsRounding) {
  Dataset data = make_campaign({});
  for (std::size_t i = 0; i < data.rows; ++i)
    data.columns[0].values[i] = 0.25 + 3 * data.columns[1].values[i];
  const auto model = formats::fit_formula(data, "q1 ~ x + x^2 + T", {});
  ASSERT_TRUE(model.has_value()) << model.error().message;
  EXPECT_EQ(model->outputs[0].terms.size(), 2u);
  EXPECT_NEAR(model->outputs[0].coefficients[1], 3, 1e-14);
}

TEST(FitErrors, TakesRowsOfAnotherTimeForAnotherMeasurement) {
  Dataset data = make_campaign({});
  const auto row_of = [&](PointSet set) {
    return static_cast<std::size_t>(std::ranges::find(data.set, set) - data.set.begin());
  };
  const std::size_t learnt = row_of(PointSet::calibration), judge = row_of(PointSet::validation);
  for (auto& column : data.columns) column.values[judge] = column.values[learnt];
  data.time_s.resize(data.rows);
  for (std::size_t row = 0; row < data.rows; ++row)
    data.time_s[row] = 100.0 * static_cast<double>(row);
  EXPECT_TRUE(formats::fit_formula(data, "q1 ~ x + T", {}));
  data.time_s[judge] = data.time_s[learnt];
  EXPECT_EQ(error_of(data, "q1 ~ x + T").reason, "SETS_OVERLAP");
}

TEST(FitErrors, CountsOnlyTheValidationRowsThatJudge) {
  Dataset data = make_campaign({});
  data.datum.assign(data.rows, 1);
  const auto marked = std::ranges::count(data.set, PointSet::validation);
  EXPECT_EQ(formats::fit_formula(data, "q1 ~ x + T", {})->lineage.rows_validation, marked);
  for (std::size_t row = 0; row < data.rows; ++row)
    if (data.set[row] == PointSet::validation) data.datum[row] = 2;
  const auto model = formats::fit_formula(data, "q1 ~ x + T", {});
  ASSERT_TRUE(model);
  EXPECT_FALSE(model->outputs[0].accuracy.a90_validation);
  EXPECT_EQ(model->lineage.rows_validation, 0);
}

}  // namespace
}  // namespace driftwise::calibration
