// A measurement that tells causes apart is one that the robot can make: on an elbow arm the box of
// what its two joints have been at has corners where its hand has never been.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "server/diagnosis/separating/separating.h"
#include "server/formats/formula/formula.h"

namespace driftwise::diagnosis {
namespace separating_reach_test {
namespace {

constexpr double kArcsec = std::numbers::pi / 648000;
constexpr double kUpper_mm = 200, kLower_mm = 180;
constexpr double kFar_mm = 260, kNear_mm = 200;  // of the square that the hand is sent to

struct Hand {
  double x = 0, y = 0;
};
Hand hand_at(double shoulder_arcsec, double elbow_arcsec) {
  const double a = shoulder_arcsec * kArcsec, b = a + elbow_arcsec * kArcsec;
  return {kUpper_mm * std::cos(a) + kLower_mm * std::cos(b),
          kUpper_mm * std::sin(a) + kLower_mm * std::sin(b)};
}

// Joint angles by the law of cosines, elbow to the left.
std::pair<double, double> joints_at(Hand hand) {
  const double far = std::hypot(hand.x, hand.y);
  const double elbow = std::acos((far * far - kUpper_mm * kUpper_mm - kLower_mm * kLower_mm) /
                                 (2 * kUpper_mm * kLower_mm));
  const double shoulder =
      std::atan2(hand.y, hand.x) -
      std::atan2(kLower_mm * std::sin(elbow), kUpper_mm + kLower_mm * std::cos(elbow));
  return {shoulder / kArcsec, elbow / kArcsec};
}

Dataset square_of_an_elbow_arm() {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> x(kNear_mm, kFar_mm), y(-30, 30);
  std::normal_distribution<double> noise(0, 0.05);
  Dataset data;
  data.rows = 160;
  data.columns = {
      {{"x", "mm"}, {}}, {{"y", "mm"}, {}}, {{"q1", "arcsec"}, {}}, {{"q2", "arcsec"}, {}}};
  for (std::size_t i = 0; i < data.rows; ++i) {
    const Hand hand{x(random), y(random)};
    const auto [shoulder, elbow] = joints_at(hand);
    const double row[] = {hand.x, hand.y, shoulder + noise(random), elbow + noise(random)};
    for (std::size_t k = 0; k < 4; ++k) data.columns[k].values.push_back(row[k]);
    data.time_s.push_back(20.0 * static_cast<double>(i));
  }
  return data;
}

// Play of the shoulder or its creep: which, the data do not tell.
Diagnosis play_or_creep(const calibration::Candidates& baseline) {
  Diagnosis found;
  Finding play{.cause = "backlash", .subject = "q1", .where = "robot"};
  play.terms = {*formats::parse_term("play(q1, 2 arcsec)")};
  play.indistinguishable_from = {"creep q1"};
  found.findings.push_back(play);
  for (const auto& output : baseline.outputs)
    found.outputs.push_back({.output = output, .unit = "arcsec", .noise_white_sd = 0.05});
  return found;
}

TEST(SeparatingPlan, OfAnArmStaysWhereItsHandHasBeen) {
  const auto data = square_of_an_elbow_arm();
  const auto baseline = *formats::Formula::parse("q1 + q2 ~ poly(x, y, 5)")->expand(data);
  const auto plan = separating_plan(data, baseline, play_or_creep(baseline), limits_from(data));
  ASSERT_TRUE(plan) << plan.error().message;
  ASSERT_TRUE(*plan);
  ASSERT_TRUE((*plan)->trajectory) << (*plan)->why;
  EXPECT_EQ((*plan)->trajectory->coordinates.front().unit, "arcsec");
  EXPECT_LT((*plan)->estimated_s, 4 * 3600);
  for (const auto& point : (*plan)->trajectory->points) {
    const Hand hand = hand_at(point.target[0], point.target[1]);
    EXPECT_GT(hand.x, kNear_mm - 7);
    EXPECT_LT(hand.x, kFar_mm + 7);
    EXPECT_LT(std::abs(hand.y), 37);
  }
}

}  // namespace
}  // namespace separating_reach_test
}  // namespace driftwise::diagnosis
