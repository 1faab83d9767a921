// A fit over two datums against the plant's truth. The whole is `two_datums` (docs/models.md).

#include <gtest/gtest.h>

#include <cstdio>

#include "server/diagnosis/check/check_standard.h"
#include "server/formats/formula/formula.h"
#include "tests/statistics/case_b_models.h"
#include "tests/statistics/two_datums_case.h"

namespace driftwise::statistics {
namespace {

constexpr std::uint64_t kFirstMachine = 7001;
constexpr int kMachines = 6;

calibration::Model fitted_to(const Dataset& data, bool move) {
  calibration::FitOptions options;
  options.move_datums = move;
  auto model = formats::fit_formula(data, kTwoDatumsFormula, options);
  EXPECT_TRUE(model) << model.error().message;
  return std::move(*model);
}

TEST(TwoDatums, FitTogetherAsWellAsIfTheirZerosWereKnown) {
  std::vector<double> by_constant, by_pose;  // S90 over that of knowing where the zeros lie
  for (int m = 0; m < kMachines; ++m) {
    const auto made = two_datums_case(kFirstMachine + static_cast<std::uint64_t>(m));
    const auto known = u90_in_third_datum(fitted_to(at_true_zeros(made), false), made);
    const auto constant = u90_in_third_datum(fitted_to(made.data, false), made);
    const auto model = fitted_to(made.data, true);
    const auto pose = u90_in_third_datum(model, made);
    ASSERT_EQ(model.datum_zeros.size(), 1u);
    ASSERT_EQ(model.datum_zeros[0].pose.size(), 3u) << model.datum_zeros[0].why_not;
    for (std::size_t k = 0; k < 3; ++k) {
      by_constant.push_back(constant[k] / known[k]);
      by_pose.push_back(pose[k] / known[k]);
      // The instruments' own frame moves as well, by fractions of a micrometre.
      EXPECT_NEAR(model.datum_zeros[0].pose[k].value, made.zeros[1].true_pose_mm[k], 2e-3);
    }
  }
  std::printf("S90 over that of known zeros, medians: constant %.2f, moved %.2f\n",
              median_of(by_constant), median_of(by_pose));
  EXPECT_LT(median_of(by_pose), 1.15);
  EXPECT_GT(median_of(by_constant), 2);
}

TEST(TwoDatums, AGoodModelIsInControlInAThird) {
  int alarms = 0;
  for (int m = 0; m < kMachines; ++m) {
    const auto made = two_datums_case(kFirstMachine + static_cast<std::uint64_t>(m));
    const auto model = fitted_to(made.data, true);
    const auto report = diagnosis::check_model(model, std::vector{third_datum_run(made)});
    for (const auto& reason : report.reasons) std::printf("%s\n", reason.c_str());
    ASSERT_NE(report.verdict, diagnosis::CheckVerdict::not_judged);
    alarms += report.verdict == diagnosis::CheckVerdict::recalibrate ? 1 : 0;
  }
  EXPECT_LE(alarms, 1);
}

}  // namespace
}  // namespace driftwise::statistics
