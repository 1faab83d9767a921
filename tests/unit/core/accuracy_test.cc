#include "server/core/data/accuracy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "server/core/text/quantity_text.h"

namespace driftwise {
namespace {

TEST(ErrorFigures, AreTheHandWorkedOnes) {
  const std::vector<double> errors = {1, 2, 3, 6};
  const auto figures = error_figures(errors);
  EXPECT_EQ(figures.rows, 4);
  EXPECT_DOUBLE_EQ(figures.mean, 3);
  EXPECT_DOUBLE_EQ(figures.u90, 1.645 * std::sqrt(14.0 / 3));
  EXPECT_DOUBLE_EQ(figures.a90, 1.645 * std::sqrt(50.0 / 4));
}

// Validation residuals of the Micro-Nano with mean +24.3 nm and s 7.8 nm: S90 alone says 13 nm.
TEST(ErrorFigures, A90HoldsTheMeanThatS90LeavesOut) {
  std::vector<double> errors;
  for (int i = 0; i < 40; ++i) errors.push_back(24.3 + (i % 2 == 0 ? 7.8 : -7.8));
  const auto figures = error_figures(errors);
  EXPECT_NEAR(figures.mean, 24.3, 1e-12);
  EXPECT_NEAR(figures.u90, 13, 0.1);
  EXPECT_NEAR(figures.a90, 42, 0.1);
}

TEST(ErrorFigures, LeaveOutRowsWithoutAValue) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(error_figures(std::vector<double>{1, none, 3}),
            error_figures(std::vector<double>{1, 3}));
  EXPECT_EQ(error_figures(std::vector<double>{none}).rows, 0);
  EXPECT_EQ(error_figures(std::vector<double>{-2}).u90, 0);
  EXPECT_DOUBLE_EQ(error_figures(std::vector<double>{-2}).a90, 3.29);
}

TEST(ErrorFigures, OfSumsAreThoseOfTheRows) {
  ErrorSums one, other;
  const std::vector<double> errors = {4, -1, 2.5, 7, 0.5};
  for (std::size_t i = 0; i < errors.size(); ++i) (i < 2 ? one : other).add(errors[i]);
  one += other;
  const auto whole = error_figures(errors), summed = error_figures(one);
  EXPECT_EQ(whole.rows, summed.rows);
  EXPECT_NEAR(whole.mean, summed.mean, 1e-14);
  EXPECT_NEAR(whole.u90, summed.u90, 1e-13);
  EXPECT_NEAR(whole.a90, summed.a90, 1e-13);
}

JudgedAccuracy judged(const char* output, const char* unit, JudgedRows rows, double a90) {
  return {output, unit, rows, {.rows = 10, .mean = 0, .u90 = a90, .a90 = a90}};
}

TEST(Heading, IsTheWorstOfEachUnit) {
  const std::vector<JudgedAccuracy> all = {
      judged("q1", "nm", JudgedRows::validation, 12), judged("q1", "nm", JudgedRows::blocks, 30),
      judged("q2", "nm", JudgedRows::validation, 41), judged("q2", "nm", JudgedRows::blocks, 9),
      judged("rx", "arcsec", JudgedRows::blocks, 0.2)};
  const auto heading = heading_of(all);
  ASSERT_EQ(heading.size(), 2u);
  EXPECT_EQ(heading[0].output, "q2");
  EXPECT_EQ(heading[0].rows, JudgedRows::validation);
  EXPECT_EQ(heading[1].unit, "arcsec");
}

TEST(Heading, TakesTheFitsOwnRowsOnlyWhereNothingWasHeldOut) {
  const std::vector<JudgedAccuracy> all = {judged("q1", "nm", JudgedRows::calibration, 99),
                                           judged("q1", "nm", JudgedRows::blocks, 30),
                                           judged("q2", "nm", JudgedRows::calibration, 50)};
  EXPECT_EQ(heading_of(all)[0].rows, JudgedRows::blocks);
  EXPECT_EQ(heading_of(std::vector{all[0], all[2]})[0].figures.a90, 99);
}

TEST(AccuracyText, NamesTheFigureTheOutputAndTheRows) {
  JudgedAccuracy one = judged("q1", "nm", JudgedRows::validation, 42.04);
  one.figures.mean = 24.31;
  one.figures.u90 = 12.83;
  EXPECT_EQ(accuracy_text(one), "42 nm (q1, validation rows, mean +24.3 nm, S90 12.8 nm)");
}

TEST(QuantityText, HasThreeDigitsAndNoExponent) {
  EXPECT_EQ(digits_text(82345), "82300");
  EXPECT_EQ(digits_text(12.849), "12.8");
  EXPECT_EQ(digits_text(9.999), "10");
  EXPECT_EQ(digits_text(0.57449), "0.574");
  EXPECT_EQ(digits_text(-3), "-3");
  EXPECT_EQ(digits_text(24.3, 3, true), "+24.3");
  EXPECT_EQ(digits_text(0), "0");
  EXPECT_EQ(digits_text(0, 3, true), "0");
  EXPECT_EQ(digits_text(2.5e-7), "2.50e-07");
  EXPECT_EQ(digits_text(INFINITY), "-");
}

TEST(MeanText, EndsWithTheLastDigitOfTheA90BesideIt) {
  EXPECT_EQ(mean_text(24.31, 42.02), "+24.3");
  EXPECT_EQ(mean_text(0.624, 9.24), "+0.62");
  EXPECT_EQ(mean_text(-151.7, 363), "-152");
  EXPECT_EQ(mean_text(2, 9.7), "+2");
  EXPECT_EQ(mean_text(-6.07e-11, 12.8), "0") << "zero by construction, but for the rounding";
  EXPECT_EQ(mean_text(-6.07e-11, 1.2e-10), "-6.10e-11") << "of errors that are as small";
  EXPECT_EQ(mean_text(0, 0), "0");
  EXPECT_EQ(mean_text(NAN, 3), "-");
}

// "8.23e+04 nm" beside "0.574 mm" in one sentence.
TEST(QuantityText, SizesThatStandTogetherShareAUnit) {
  const SizeUnit unit = size_unit({8.23e4, 5.74e5}, "nm");
  EXPECT_EQ(unit.unit, "um");
  EXPECT_EQ(digits_text(8.23e4 * unit.factor), "82.3");
  EXPECT_EQ(digits_text(5.74e5 * unit.factor), "574");
  EXPECT_EQ(quantity_text(6199809.9, "nm"), "6.2 mm");
  EXPECT_EQ(quantity_text(12345.6, "arcsec"), "12300 arcsec");
  EXPECT_EQ(quantity_text(3, "1"), "3");
}

}  // namespace
}  // namespace driftwise
