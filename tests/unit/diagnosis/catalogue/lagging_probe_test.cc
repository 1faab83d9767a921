// A touching probe that friction holds back on the side that it came from, on a carriage that two
// crossed belts move: each belt moves both coordinates, so that no motor's play looks like it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "server/diagnosis/catalogue/cause.h"
#include "tests/unit/diagnosis/diagnosed.h"

namespace driftwise::diagnosis {
namespace lagging_probe_test {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Not;

constexpr double kWidth_mm = 300e-6, kNoise_mm = 60e-6;

// The place of what lags behind by half the width at most, from its last place.
double dragged(double tip, double at) {
  return std::clamp(tip, at - kWidth_mm / 2, at + kWidth_mm / 2);
}

enum class Lags { nothing, probe_of_y, first_belt };

// 300 points at random in a square of 20 mm. Each instrument and scale has noise of its own.
Dataset crossed_belts(Lags lags, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> anywhere(-10, 10);
  std::normal_distribution<double> noise(0, kNoise_mm);
  Dataset data;
  data.rows = 300;
  data.columns = {{{"x", "mm"}, {}}, {{"y", "mm"}, {}}, {{"q1", "mm"}, {}}, {{"q2", "mm"}, {}}};
  double tip = 0, carriage = 0;
  for (std::size_t i = 0; i < data.rows; ++i) {
    data.time_s.push_back(20.0 * static_cast<double>(i));
    const double x = anywhere(random), y = anywhere(random);
    tip = dragged(tip, y);
    carriage = dragged(carriage, x + y);
    const double q1 = lags == Lags::first_belt ? 2 * (x + y) - carriage : x + y;
    const double read = lags == Lags::probe_of_y ? tip : y;
    data.columns[0].values.push_back(x + noise(random));
    data.columns[1].values.push_back(read + noise(random));
    data.columns[2].values.push_back(q1);
    data.columns[3].values.push_back(x - y);
  }
  return data;
}

Diagnosis diagnosis_of(Lags lags, unsigned seed) {
  return diagnosed(crossed_belts(lags, seed), "q1 + q2 ~ x + y");
}

TEST(AProbeThatLagsBehind, IsNamedWithItsWidthOnAllMotorsTogether) {
  for (const unsigned seed : {1, 2}) {
    const auto found = diagnosis_of(Lags::probe_of_y, seed);
    ASSERT_THAT(names_found(found), ElementsAre("probe_hysteresis y")) << "seed " << seed;
    const auto& finding = found.findings.front();
    ASSERT_EQ(finding.parameters.size(), 1u);
    EXPECT_EQ(finding.parameters[0].name, "width_nm");
    EXPECT_NEAR(finding.parameters[0].value, 300, 45);
    ASSERT_TRUE(finding.parameters[0].ci90);
    EXPECT_LT(finding.parameters[0].ci90->low, 300);
    EXPECT_GT(finding.parameters[0].ci90->high, 300);
    EXPECT_THAT(finding.sentence, ::testing::HasSubstr("hat reads y lags behind its motion"));
  }
}

TEST(AProbeThatLagsBehind, IsOfTheReadingsAndMovesNoTarget) {
  const auto finding = diagnosis_of(Lags::probe_of_y, 1).findings.front();
  EXPECT_EQ(finding.applies_to, effects::AppliesTo::correction);
}

TEST(AProbeThatLagsBehind, IsNotNamedWhereABeltHasPlayOrNothingLags) {
  for (const unsigned seed : {1, 2}) {
    EXPECT_THAT(names_found(diagnosis_of(Lags::first_belt, seed)), ElementsAre("backlash q1"));
    EXPECT_THAT(names_found(diagnosis_of(Lags::nothing, seed)), ::testing::IsEmpty());
  }
}

// Its own motor's play has the same column: the contract's name for that is backlash.
TEST(AProbeThatLagsBehind, IsNoCauseWhereOneMotorMovesTheCoordinateAlone) {
  const auto causes = [](Dataset data) {
    std::vector<std::string> names;
    for (const auto& cause :
         catalogue_for(data, formats::Formula::parse("q1 + q2 ~ x + y")->expand(data)->terms, {})
             .causes)
      names.push_back(name_of(cause));
    return names;
  };
  auto data = crossed_belts(Lags::nothing, 1);
  EXPECT_THAT(causes(data), Contains("probe_hysteresis y"));
  data.columns[3].values = data.columns[1].values;  // q2 = y
  EXPECT_THAT(causes(data), Contains("probe_hysteresis x"));
  EXPECT_THAT(causes(data), Not(Contains("probe_hysteresis y")));
}

}  // namespace
}  // namespace lagging_probe_test
}  // namespace driftwise::diagnosis
