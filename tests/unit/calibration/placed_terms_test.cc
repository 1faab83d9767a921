// Terms that belong to some of the outputs only.

#include "server/calibration/placed_terms.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "server/effects/term_order.h"
#include "server/formats/formula/formula.h"

namespace driftwise::calibration {
namespace {

// q1 and q2 over x and two thermometers; q1 alone goes with t02.
Dataset two_motors() {
  std::mt19937_64 random(11);
  std::normal_distribution<double> noise_mm(0, 3e-6);
  Dataset data;
  data.rows = 160;
  for (const char* symbol : {"q1", "q2", "x"}) data.columns.push_back({{symbol, "mm"}, {}});
  for (const char* symbol : {"t01", "t02"}) data.columns.push_back({{symbol, "degC"}, {}});
  for (std::size_t row = 0; row < data.rows; ++row) {
    const double x = -4 + 8.0 * static_cast<double>(row * 37 % 160) / 160;
    const double t1 = 20 + 0.5 * std::sin(0.05 * static_cast<double>(row));
    const double t2 = 20 + 0.3 * std::cos(0.11 * static_cast<double>(row)) + 0.2 * (t1 - 20);
    data.time_s.push_back(20.0 * static_cast<double>(row));
    const double values[] = {1 + 1.0002 * x + 2e-5 * t1 + 4e-5 * t2 + noise_mm(random),
                             2 - 0.9 * x + 1e-5 * t1 + noise_mm(random), x, t1, t2};
    for (std::size_t c = 0; c < data.columns.size(); ++c)
      data.columns[c].values.push_back(values[c]);
  }
  return data;
}

FitOptions options_for(const Dataset& data, const std::string& formula, Select select) {
  FitOptions options;
  options.candidates = *formats::Formula::parse(formula)->expand(data);
  options.select = select;
  return options;
}

const effects::Term kT2 = *formats::parse_term("t02");

// Outputs are fitted each by itself: with the term in one, that is the fit with it, and the other
// is the fit without it, to the last figures.
class PlacedTerms : public testing::TestWithParam<Select> {};
TEST_P(PlacedTerms, AreFittedInTheirOwnOutputsAndLeaveTheOthersAsTheyWere) {
  const auto data = two_motors();
  const auto placed = fit_placed(data, options_for(data, "q ~ x + t01", GetParam()),
                                 {{kT2, {"q1"}}}, "q ~ x + t01 + t02")
                          .value();
  const auto with = fit(data, options_for(data, "q1 ~ x + t01 + t02", Select::all)).value();
  const auto without = fit(data, options_for(data, "q2 ~ x + t01", Select::all)).value();
  const OutputModel* expected[] = {&with.outputs[0], &without.outputs[0]};
  for (std::size_t o = 0; o < 2; ++o) {
    const auto& is = placed.outputs[o];
    ASSERT_EQ(is.terms, expected[o]->terms);
    for (Eigen::Index k = 0; k < is.coefficients.size(); ++k)
      EXPECT_NEAR(is.coefficients[k], expected[o]->coefficients[k],
                  1e-6 * std::sqrt(expected[o]->covariance(k, k)));
    EXPECT_NEAR(is.accuracy.rmse, expected[o]->accuracy.rmse, 1e-6 * expected[o]->accuracy.rmse);
    EXPECT_NEAR(*is.accuracy.u90_blocks, *expected[o]->accuracy.u90_blocks,
                1e-6 * *expected[o]->accuracy.u90_blocks);
  }
  EXPECT_EQ(placed.formula, "q ~ x + t01 + t02");
}
INSTANTIATE_TEST_SUITE_P(Table, PlacedTerms, testing::Values(Select::all, Select::stepwise),
                         [](const auto& row) {
                           return std::string(row.param == Select::all ? "all" : "stepwise");
                         });

// A motor that slips by 50 nm at 1610 s: the constant is that of where it is now.
TEST(PlacedTerm, ThatStaysEndsInTheConstant) {
  auto data = two_motors();
  const double slip_mm = 50e-6;
  const auto options = options_for(data, "q ~ x + t01", Select::all);
  const auto before = fit(data, options).value();
  for (std::size_t row = 0; row < data.rows; ++row)
    if (data.time_s[row] > 1610) data.columns[1].values[row] += slip_mm;
  const auto after =
      fit_placed(data, options, {{*formats::parse_term("step(1610 s)"), {"q2"}, true}},
                 options.candidates.formula)
          .value();
  const auto &was = before.outputs[1], &is = after.outputs[1];
  ASSERT_EQ(is.terms, was.terms);
  const auto at_20_degC = [](const OutputModel& output) {
    return output.coefficients[0] + 20 * output.coefficients[2];
  };
  // Noise of 3 nm in 80 rows on either side: 0.5 nm of the step.
  EXPECT_NEAR(at_20_degC(is) - at_20_degC(was), slip_mm, 2e-6);
  EXPECT_NEAR(is.accuracy.rmse, was.accuracy.rmse, 0.02 * was.accuracy.rmse);
  EXPECT_EQ(is.covariance.rows(), is.coefficients.size());
  EXPECT_EQ(after.outputs[0].coefficients.size(), 3);
}

TEST(PlacedTerm, ThatTheFormulaHasStaysInEveryOutput) {
  const auto data = two_motors();
  const auto options = options_for(data, "q ~ x + t01", Select::all);
  const auto model =
      fit_placed(data, options, {{*formats::parse_term("t01"), {"q1"}}}, options.candidates.formula)
          .value();
  EXPECT_EQ(model.outputs[1].terms.size(), 3u);
}

}  // namespace
}  // namespace driftwise::calibration
