// A touching instrument whose tip dry friction holds: it follows once what it touches has moved by
// the width of the hysteresis. Written as that law, not as two levels.

#include "server/diagnosis/noise/two_sides.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <random>

#include "server/core/data/dataset.h"
#include "server/diagnosis/diagnose.h"
#include "server/formats/formula/formula.h"
#include "tests/unit/diagnosis/diagnosed.h"

namespace driftwise::diagnosis {
namespace two_sides_test {  // other tests have rows of their own
namespace {

constexpr std::size_t kRows = 240;
constexpr double kWidth_mm = 1.5e-3;

// The tip follows its end-effector through these places, in order.
class Tip {
 public:
  double after(double place_mm) {
    at_mm_ = std::clamp(at_mm_, place_mm - kWidth_mm / 2, place_mm + kWidth_mm / 2);
    return at_mm_;
  }

 private:
  double at_mm_ = 0;
};

struct Machine {
  bool friction = false;
  bool approach_known = false;  // the last way is that of the motor, and nothing comes after it
  int heights = 0;              // 0: any
  double noise_mm = 1e-4;
};

// Three motors carry a platform that turns and lifts; each point is reached with an overshoot to
// either side that no channel shows. Every third point validates.
Dataset measured(const Machine& machine, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> even(-1, 1);
  std::normal_distribution<double> normal;
  Dataset data;
  data.rows = kRows;
  std::vector<std::vector<double>> q(3), pose(3);
  std::vector<double> t;
  Tip tip;
  for (std::size_t i = 0; i < kRows; ++i) {
    const double rx = 4e-3 * even(random), ry = 4e-3 * even(random), height = 2 * even(random);
    const double z = machine.heights == 0
                         ? height
                         : -2 + 4 * std::floor(machine.heights * static_cast<double>(i) / kRows) /
                                    (machine.heights - 1);
    const double warm = 21 + 0.3 * std::sin(static_cast<double>(i) / 40);
    const bool from_above = machine.heights == 0 || i % 11 == 0 ? even(random) < 0 : z < -0.1;
    if (!machine.approach_known) tip.after(z + (from_above ? 5e-3 : -5e-3));
    const double read = machine.friction ? tip.after(z) : z;
    for (std::size_t k = 0; k < 3; ++k) {
      const double angle = 2.0943951 * static_cast<double>(k);
      const double lever_x = 60 * std::cos(angle), lever_y = 60 * std::sin(angle);
      q[k].push_back(z + lever_y * rx - lever_x * ry +
                     0.02 * static_cast<double>(k + 1) * z * rx * 1e2 + 1e-3 * (warm - 21));
    }
    pose[0].push_back(rx * 206264.806 + 0.02 * normal(random));
    pose[1].push_back(ry * 206264.806 + 0.02 * normal(random));
    pose[2].push_back(read + machine.noise_mm * normal(random));
    t.push_back(warm);
    data.time_s.push_back(30.0 * static_cast<double>(i));
    data.set.push_back(i % 3 == 2 ? PointSet::validation : PointSet::calibration);
  }
  data.columns = {{{"q1", "mm"}, q[0]},        {{"q2", "mm"}, q[1]},        {{"q3", "mm"}, q[2]},
                  {{"rx", "arcsec"}, pose[0]}, {{"ry", "arcsec"}, pose[1]}, {{"z", "mm"}, pose[2]},
                  {{"t01", "degC"}, t}};
  return data;
}

std::vector<std::string> causes_in(const Diagnosis& found) {
  std::vector<std::string> names;
  for (const auto& finding : found.findings) names.push_back(finding.cause);
  return names;
}

constexpr auto kPlatform = "q ~ poly(rx, ry, z, 2) + T";

TEST(ATouchingInstrument, ThatFrictionHoldsIsNamedWithItsWidthAndNothingBesideIt) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const auto found = diagnosed(measured({.friction = true}, seed), kPlatform);
    ASSERT_THAT(causes_in(found), testing::ElementsAre("probe_hysteresis")) << seed;
    EXPECT_EQ(found.findings[0].subject, "z");
    ASSERT_EQ(found.findings[0].parameters.size(), 1U);
    EXPECT_EQ(found.findings[0].parameters[0].name, "width_nm");
    EXPECT_NEAR(found.findings[0].parameters[0].value, kWidth_mm * 1e6, 0.05 * kWidth_mm * 1e6);
  }
}

TEST(ATouchingInstrument, IsNotPromisedToBeBetterOnRowsWhoseSideNothingTells) {
  const auto found = diagnosed(measured({.friction = true}, 4), kPlatform);
  for (const auto& output : found.outputs) {
    EXPECT_GT(*output.a90_validation_before, 0.4 * kWidth_mm * 1e6) << output.output;
    EXPECT_GT(*output.a90_validation_after, 0.9 * *output.a90_validation_before) << output.output;
  }
  EXPECT_EQ(found.extended_formula, found.baseline_formula);
}

// Heights one after the other, those below zero from above and the others from below, but for one
// in eleven: the polynomial in z takes up a part of the sides.
TEST(ATouchingInstrument, WhoseSideGoesMostlyWithAVariableOfTheSimulationIsNamed) {
  const auto found =
      diagnosed(measured({.friction = true, .heights = 7}, 9), "q ~ poly(rx, ry, z, 3) + T");
  ASSERT_THAT(causes_in(found), testing::ElementsAre("probe_hysteresis"));
  EXPECT_EQ(found.findings[0].subject, "z");
  EXPECT_NEAR(found.findings[0].parameters[0].value, kWidth_mm * 1e6, 0.1 * kWidth_mm * 1e6);
}

// A straightness table of two metres whose dial gauge sticks: what it reads is the deviation, which
// hardly follows the position.
TEST(ATouchingInstrument, ThatReadsADeviationIsNamedByTheDeviation) {
  std::mt19937 random(21);
  std::normal_distribution<double> normal;
  DatasetColumn x{{"x", "mm"}, {}}, ex{{"ex", "um"}, {}};
  Dataset data;
  data.rows = 200;
  for (std::size_t i = 0; i < data.rows; ++i) {
    const double place_mm = 100.0 * static_cast<double>((i / 2) % 20);
    const double side = random() % 2 == 0 ? 6 : -6;
    x.values.push_back(place_mm);
    ex.values.push_back(3e-3 * place_mm + side + 0.8 * normal(random));
    data.time_s.push_back(20.0 * static_cast<double>(i));
  }
  data.columns = {x, ex};
  const auto found = diagnosed(data, "ex ~ x");
  ASSERT_THAT(causes_in(found), testing::ElementsAre("probe_hysteresis"));
  EXPECT_EQ(found.findings[0].subject, "ex");
  EXPECT_NEAR(found.findings[0].parameters[0].value, 12e3, 600);
}

TEST(ATouchingInstrument, WithoutFrictionIsNotNamed) {
  for (const unsigned seed : {5U, 6U, 7U})
    EXPECT_THAT(causes_in(diagnosed(measured({}, seed), kPlatform)), testing::IsEmpty()) << seed;
}

TEST(ATouchingInstrument, WhoseSideTheMotorsWayTellsHasPlay) {
  std::mt19937_64 random(8);
  std::normal_distribution<double> normal;
  const Dataset both = measured({.friction = false, .approach_known = true}, 8);
  Dataset data = both;  // one motor that lifts, so that its way is that of the tip
  data.columns = {both.columns[0], both.columns[5], both.columns[6]};
  data.columns[0].values = both.columns[5].values;
  Tip tip;
  for (double& z : data.columns[1].values) z = tip.after(z) + 1e-4 * normal(random);
  for (const char* way : {"q1 ~ z + z^2 + T", "z ~ q1 + q1^2 + T"})
    EXPECT_THAT(causes_in(diagnosed(data, way)), testing::ElementsAre("backlash")) << way;
}

// Of one series about nothing but a constant.
std::optional<TwoSides> sides_of(const std::function<double(std::mt19937_64&, std::size_t)>& value,
                                 const Eigen::MatrixXd& channels = {}) {
  std::mt19937_64 random(11);
  constexpr Eigen::Index kLong = 400;
  Timeline timeline{Eigen::VectorXd::LinSpaced(kLong, 0, 1e4), std::vector<char>(kLong, 0), {}};
  timeline.restart[0] = 1;
  Eigen::MatrixXd series(kLong, 1);
  for (Eigen::Index i = 0; i < kLong; ++i)
    series(i, 0) = value(random, static_cast<std::size_t>(i));
  return two_sides(timeline, SoftBase(Eigen::MatrixXd::Ones(kLong, 1)), series, channels);
}

TEST(TwoSides, AreFoundWithTheirDistance) {
  std::bernoulli_distribution up(0.3);
  std::normal_distribution<double> normal;
  const auto found =
      sides_of([&](auto& random, auto) { return (up(random) ? 8.0 : 0.0) + normal(random); });
  ASSERT_TRUE(found);
  EXPECT_NEAR(2 * std::abs(found->half[0]), 8, 0.3);
  EXPECT_NEAR(found->apart, 8, 0.5);
}

// A guide with a particle on it: twelve places in turn, the third and the fourth are lifted.
TEST(TwoSides, ThatThePlaceTellsAreABumpOnTheGuide) {
  std::normal_distribution<double> normal;
  Eigen::VectorXd place(400);
  for (Eigen::Index i = 0; i < place.size(); ++i) place[i] = static_cast<double>(i % 12);
  const auto lifted = [](std::size_t i) { return i % 12 == 2 || i % 12 == 3; };
  const auto value = [&](auto& random, auto i) { return (lifted(i) ? 8.0 : 0.0) + normal(random); };
  EXPECT_TRUE(sides_of(value));
  EXPECT_FALSE(sides_of(value, place));
}

// Weights put on and taken off between the points; the thermometer tells nothing.
TEST(TwoSides, ThatTheLoadTellsAreARobotThatGivesWay) {
  std::normal_distribution<double> normal;
  std::mt19937_64 random(12);
  const auto is_loaded = [](std::size_t i) { return i * i % 11 < 5; };
  Eigen::MatrixXd channels(400, 2);
  for (Eigen::Index i = 0; i < channels.rows(); ++i)
    channels.row(i) << normal(random), is_loaded(static_cast<std::size_t>(i)) ? 2.0 : 0.5;
  const auto value = [&](auto& noise, auto i) {
    return (is_loaded(i) ? 8.0 : 0.0) + normal(noise);
  };
  EXPECT_TRUE(sides_of(value, channels.col(0)));
  EXPECT_FALSE(sides_of(value, channels));
}

TEST(TwoSides, ThatThePlaceTellsOnlyMostlyAreSides) {
  std::normal_distribution<double> normal;
  Eigen::VectorXd place(400);
  for (Eigen::Index i = 0; i < place.size(); ++i) place[i] = static_cast<double>(i % 12);
  const auto value = [&](auto& random, auto i) {
    return ((i % 12 < 4) != (i % 25 == 0) ? 8.0 : 0.0) + normal(random);  // one in 25 strays
  };
  EXPECT_TRUE(sides_of(value, place));
}

TEST(TwoSides, AreNotSeenInNormalStudentEvenOrSinusoidalValues) {
  std::normal_distribution<double> normal;
  std::student_t_distribution<double> tails(2.5);
  std::uniform_real_distribution<double> even(-1, 1);
  EXPECT_FALSE(sides_of([&](auto& random, auto) { return normal(random); }));
  EXPECT_FALSE(sides_of([&](auto& random, auto) { return tails(random); }));
  EXPECT_FALSE(sides_of([&](auto& random, auto) { return even(random); }));
  EXPECT_FALSE(sides_of([&](auto& random, auto i) {
    return 20 * std::sin(0.7 * static_cast<double>(i)) + normal(random);
  }));
}

TEST(TwoSides, OfAJumpThatSlowNoiseExplainsDoNotPayTheirPrice) {
  std::normal_distribution<double> normal;
  EXPECT_FALSE(
      sides_of([&](auto& random, auto i) { return (i < 200 ? 0.0 : 8.0) + normal(random); }));
}

}  // namespace
}  // namespace two_sides_test
}  // namespace driftwise::diagnosis
