#include "server/diagnosis/rows/inverted_baseline.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/diagnosis/rows/predicted_pose.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kBentNoise_mm = 1e-5;

// Two motors at 12 x 12 commanded positions, each twice, and the pose measured to 10 nm. bend: per
// mm, q1 = x + bend (x^2 + y^2) and q2 = y + bend x y.
struct Bent {
  Dataset data;
  std::vector<double> y_true;
};

Bent bent_robot(double bend) {
  std::mt19937_64 random(17);
  std::normal_distribution<double> noise(0, kBentNoise_mm);
  Bent robot;
  Dataset& data = robot.data;
  data.columns = {{{"q1", "mm"}, {}}, {{"q2", "mm"}, {}}, {{"x", "mm"}, {}}, {{"y", "mm"}, {}}};
  for (int row = 0; row < 288; ++row) {
    const int place = row % 144;
    const double q1 = -66 + 12.0 * (place / 12), q2 = -66 + 12.0 * (place % 12);
    double x = q1, y = q2;
    for (int i = 0; i < 60; ++i) {  // a contraction: bend times 66 mm is far below 1
      const double before = x;
      x = q1 - bend * (x * x + y * y);
      y = q2 - bend * before * y;
    }
    robot.y_true.push_back(y);
    data.columns[0].values.push_back(q1);
    data.columns[1].values.push_back(q2);
    data.columns[2].values.push_back(x + noise(random));
    data.columns[3].values.push_back(y + noise(random));
    data.time_s.push_back(20.0 * row);
    ++data.rows;
  }
  return robot;
}

Problem laid_out_bent(const Dataset& data) {
  std::vector<effects::Term> terms;
  for (const auto& [a, b] : {std::pair{1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}}) {
    effects::Term term;
    if (a > 0) term.factors.emplace_back(effects::Power{"x", a});
    if (b > 0) term.factors.emplace_back(effects::Power{"y", b});
    terms.push_back(std::move(term));
  }
  return *lay_out(data, {"q ~ poly(x, y, 2)", {"q1", "q2"}, std::move(terms), true}, 4000);
}

template <typename Values>
double rms_apart(const Values& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < b.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(b.size()));
}

TEST(InvertedBaseline, GivesAWaveItsPhaseWhereNoPolynomialInTheMotorsFollowsThePose) {
  const Bent robot = bent_robot(6e-4);
  EXPECT_GT(rms_apart(*predicted_coordinate(robot.data, "y"), robot.y_true), 1e-3);
  // Six coefficients from 288 rows carry sqrt(6 / 288) = 0.15 of the noise.
  EXPECT_LT(rms_apart(laid_out_bent(robot.data).prepared.phase_values("y"), robot.y_true),
            0.3 * kBentNoise_mm);
}

TEST(InvertedBaseline, GivesWayToThePolynomialWhereThatFollowsThePoseAsWell) {
  const Bent robot = bent_robot(0);
  EXPECT_LT(rms_apart(laid_out_bent(robot.data).prepared.phase_values("y"),
                      *predicted_coordinate(robot.data, "y")),
            1e-12);
}

TEST(InvertedBaseline, IsEmptyWhereTheOutputsAreNotOneMotorForEachCoordinate) {
  Problem problem = laid_out_bent(bent_robot(6e-4).data);
  problem.outputs.pop_back();
  EXPECT_TRUE(inverted_baseline(problem)->empty());
}

}  // namespace
}  // namespace driftwise::diagnosis
