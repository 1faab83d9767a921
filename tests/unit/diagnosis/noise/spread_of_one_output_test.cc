// Noise that changes on one of two axes. The other axis is as it was: alone and together with the
// first one its rows say the same.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "server/diagnosis/noise/noise_model.h"
#include "tests/unit/diagnosis/diagnosed.h"

namespace driftwise::diagnosis {
namespace spread_of_one_output_test {
namespace {

constexpr std::size_t kRows = 300;

// Two axes with 10 nm of noise each, drawn places, a load that the second one gives way under.
// louder: of the noise of the first axis, by row.
template <typename Louder>
Dataset two_axes(unsigned seed, const Louder& louder, double compliance_nm_per_n) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Dataset data;
  data.rows = kRows;
  data.columns = {{{"q1", "mm"}, {}},
                  {{"q2", "mm"}, {}},
                  {{"x", "mm"}, {}},
                  {{"y", "mm"}, {}},
                  {{"force", "N"}, {}}};
  for (std::size_t i = 0; i < kRows; ++i) {
    const double x = 5.0 * static_cast<double>(random() % 11);
    const double y = 5.0 * static_cast<double>(random() % 11);
    const double force_n = static_cast<double>(random() % 5);
    data.time_s.push_back(30.0 * static_cast<double>(i));
    data.columns[0].values.push_back(x + 1e-5 * louder(i, x) * normal(random));
    data.columns[1].values.push_back(y + 1e-5 * normal(random) +
                                     1e-6 * compliance_nm_per_n * force_n);
    data.columns[2].values.push_back(x);
    data.columns[3].values.push_back(y);
    data.columns[4].values.push_back(force_n);
  }
  return data;
}

double from_the_middle(std::size_t row, double) { return row < kRows / 2 ? 1 : 4; }
double with_the_place(std::size_t, double x) { return 1 + x / 12.5; }

const Finding* compliance_in(const Diagnosis& found) {
  const auto at =
      std::ranges::find(found.findings, std::string("force_compliance"), &Finding::cause);
  return at == found.findings.end() ? nullptr : &*at;
}

TEST(SpreadOfOneOutput, IsNoSpreadOfTheOther) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const Dataset data = two_axes(seed, from_the_middle, 0);
    const auto alone = diagnosed(data, "q2 ~ y + y^2");
    const auto both = diagnosed(data, "q ~ poly(x, y, 2)");
    EXPECT_EQ(alone.verdict, Verdict::adequate) << seed;
    EXPECT_THAT(names_found(both), testing::ElementsAre("noise_change q1")) << seed;
    EXPECT_EQ(both.verdict, Verdict::extended) << seed;
  }
}

TEST(SpreadOfOneOutput, LeavesASizeOnTheOtherAsItIsAlone) {
  for (const bool by_place : {false, true}) {
    const Dataset data =
        by_place ? two_axes(7, with_the_place, 5) : two_axes(6, from_the_middle, 5);
    const auto alone = diagnosed(data, "q2 ~ y + y^2");
    const auto both = diagnosed(data, "q ~ poly(x, y, 2)");
    const Finding *one = compliance_in(alone), *other = compliance_in(both);
    ASSERT_NE(one, nullptr) << by_place;
    ASSERT_NE(other, nullptr) << by_place;
    const auto &size = one->parameters.front(), &again = other->parameters.front();
    ASSERT_TRUE(size.ci90 && again.ci90);
    const double reach = (size.ci90->high - size.ci90->low) / 2;
    EXPECT_NEAR(again.value, size.value, 0.25 * reach) << by_place;
    EXPECT_NEAR((again.ci90->high - again.ci90->low) / 2, reach, 0.1 * reach) << by_place;
    EXPECT_NEAR(both.outputs[1].noise_white_sd, 10, 1.2) << by_place;
  }
}

TEST(SpreadOfOneOutput, IsDrawnForThatOutput) {
  constexpr Eigen::Index kMany = 4000;
  Timeline timeline;
  timeline.time_s = Eigen::VectorXd::LinSpaced(kMany, 0, kMany - 1);
  timeline.restart.assign(kMany, 0);
  timeline.restart.front() = 1;
  timeline.sd = Eigen::MatrixXd::Ones(kMany, 2);
  timeline.sd.col(0).tail(kMany / 2).setConstant(4);
  std::mt19937_64 random(1);
  const Eigen::MatrixXd drawn =
      simulated_noise(timeline, {{0, 1}, {0, 1}}, Eigen::Matrix2d::Identity(), random);
  const auto rms_of_half = [&](Eigen::Index output) {
    return drawn.col(output).tail(kMany / 2).norm() / std::sqrt(kMany / 2.0);
  };
  EXPECT_NEAR(rms_of_half(0), 4, 0.3);  // five standard errors
  EXPECT_NEAR(rms_of_half(1), 1, 0.08);
  Eigen::MatrixXd white = drawn;
  for (Eigen::Index o = 0; o < 2; ++o) Whitener(timeline, {0, 1}, o).apply(white.col(o));
  EXPECT_NEAR(white.col(0).tail(kMany / 2).norm() / std::sqrt(kMany / 2.0), 1, 0.08);
}

}  // namespace
}  // namespace spread_of_one_output_test
}  // namespace driftwise::diagnosis
