// Against values computed in R 4.2 (pf, pt with log.p) and textbook quantiles.

#include "server/calibration/linear/tail.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace driftwise::calibration {
namespace {

TEST(Tail, IsTheCauchyDistributionAtOneDegreeOfFreedom) {
  for (const double t : {0.001, 0.5, 1.0, 30.0, 1e6})
    EXPECT_NEAR(t_two_sided_p(t, 1) / (1 - 2 / M_PI * std::atan(t)), 1, t < 100 ? 1e-12 : 1e-9)
        << t;
}

TEST(Tail, HasAClosedFormAtTwoDegreesOfFreedom) {
  // P(|T| > t) = 1 - t / sqrt(2 + t^2), written without cancellation
  for (const double t : {0.1, 2.0, 1e4, 1e8})
    EXPECT_NEAR(t_two_sided_p(t, 2) / (2 / (std::sqrt(2 + t * t) * (std::sqrt(2 + t * t) + t))), 1,
                1e-12)
        << t;
}

TEST(Tail, ReachesTheSmallestDoublesAndThenIsZero) {
  // four degrees of freedom: P = 1 - s (3 - s^2) / 2 with s^2 = t^2 / (4 + t^2); leading term 6 /
  // t^4
  EXPECT_NEAR(t_two_sided_p(1e50, 4) / 6e-200, 1, 1e-9);
  EXPECT_GT(t_two_sided_p(30, 547), 1e-120);
  EXPECT_LT(t_two_sided_p(30, 547), 1e-110);
  EXPECT_EQ(t_two_sided_p(1e9, 1e5), 0);
  EXPECT_EQ(t_two_sided_p(std::numeric_limits<double>::infinity(), 3), 0);
}

TEST(Tail, OfFIsOneAtNothingAndForNonsense) {
  EXPECT_EQ(f_upper_p(0, 3, 10), 1);
  EXPECT_EQ(f_upper_p(std::nan(""), 3, 10), 1);
  EXPECT_NEAR(f_upper_p(3.708264819, 3, 10), 0.05, 1e-6);  // F tables, 95 %
}

TEST(Tail, QuantileIsTheTableValue) { EXPECT_NEAR(t_quantile(0.95, 9), 1.833112933, 1e-8); }

}  // namespace
}  // namespace driftwise::calibration
