// Noise that is no cause, each mechanism in the small, by plain formulas: places that a motor
// repeats exactly, a cycle of the room faster than the sampling, a jump of one thermometer that
// nothing follows, a beam that is noisier the longer it is, a jump in correlated noise.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "server/diagnosis/diagnose.h"
#include "server/diagnosis/noise/ground.h"
#include "server/diagnosis/noise/noise_model.h"
#include "server/diagnosis/noise/robust.h"
#include "server/diagnosis/rows/problem.h"
#include "server/diagnosis/rows/smoothing.h"
#include "server/diagnosis/rows/spread_over_places.h"
#include "server/diagnosis/search/column_bank.h"
#include "server/formats/formula/formula.h"
#include "tests/unit/diagnosis/diagnosed.h"

namespace driftwise::diagnosis {
namespace noise_mechanisms_test {  // other tests have rows of their own
namespace {

calibration::Candidates baseline_of(const std::string& formula, const Dataset& data) {
  return *formats::Formula::parse(formula)->expand(data);
}

std::vector<std::string> names_in(const Diagnosis& found) {
  std::vector<std::string> names;
  for (const auto& finding : found.findings) names.push_back(finding.cause);
  return names;
}

Eigen::MatrixXd of_unit_length(const Eigen::MatrixXd& columns) {
  const Eigen::RowVectorXd lengths = columns.colwise().norm();
  return columns * lengths.cwiseInverse().asDiagonal();
}

// An axis over `places` places of 8 mm, drawn; noise_nm(place in -1..1) is the noise's spread.
template <typename SpreadOf>
Dataset one_axis(unsigned seed, std::size_t rows, std::size_t places, const SpreadOf& noise_nm) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Dataset data;
  data.rows = rows;
  data.columns = {{{"q1", "mm"}, {}}, {{"x", "mm"}, {}}};
  for (std::size_t i = 0; i < rows; ++i) {
    data.time_s.push_back(20.0 * static_cast<double>(i));
    const double u =
        2 * static_cast<double>(random() % places) / static_cast<double>(places - 1) - 1;
    data.columns[0].values.push_back(4 * u);
    data.columns[1].values.push_back(4 * u * (1 + 2e-5) + 1e-6 * noise_nm(u) * normal(random));
  }
  return data;
}

TEST(NoiseOnALattice, IsNoPolynomialThatTheLatticeDoesNotDetermine) {
  Dataset data = one_axis(1, 200, 5, [](double) { return 5.0; });
  data.time_s.clear();  // the predicted pose may go with time
  const auto problem = lay_out(data, baseline_of("q1 ~ x + x^2 + x^3 + x^4", data), 4000);
  ASSERT_TRUE(problem);
  ASSERT_EQ(problem->base.size(), 5U);
  const effects::Term fifth{{effects::Power{"x", 5}}};
  const Eigen::MatrixXd column = problem->learned(*filled_columns(*problem, {fifth}));
  const Eigen::MatrixXd base = of_unit_length(problem->learned(problem->base_columns));
  const Eigen::VectorXd left =
      column.col(0) - base * base.colPivHouseholderQr().solve(column.col(0));
  // Of the measured pose it would leave noise over stroke, 1e-6 and more, and that is the noise.
  EXPECT_LT(left.norm(), 1e-10 * column.norm());
}

// A rotary axis without times whose only thermometer is in the baseline: the catalogue is empty.
TEST(DataThatNoCauseCanBeAskedOf, AreJudgedByWhatIsLeft) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  Dataset data;
  data.rows = 120;
  data.columns = {{{"q1", "arcsec"}, {}}, {{"rz", "arcsec"}, {}}, {{"t01", "degC"}, {}}};
  for (std::size_t i = 0; i < data.rows; ++i) {
    const double angle = 700.0 * static_cast<double>(random() % 9);
    data.columns[0].values.push_back(angle);
    data.columns[1].values.push_back(angle + 0.05 * normal(random));
    data.columns[2].values.push_back(20 + 0.1 * normal(random));
  }
  EXPECT_EQ(diagnosed(data, "q1 ~ rz + T").verdict, Verdict::adequate);
}

TEST(NoiseOnALattice, IsMissedByTheBaselineAsItWasMeasured) {
  const Dataset data = one_axis(2, 200, 5, [](double) { return 5.0; });
  const auto problem = lay_out(data, baseline_of("q1 ~ x + x^2", data), 4000);
  ASSERT_TRUE(problem);
  const auto missed = [](const Eigen::MatrixXd& raw, const Eigen::VectorXd& measured) {
    const Eigen::MatrixXd columns = of_unit_length(raw);
    return Eigen::VectorXd(measured - columns * columns.colPivHouseholderQr().solve(measured));
  };
  Eigen::MatrixXd at_measured(200, 3);
  const Eigen::Map<const Eigen::VectorXd> x(data.columns[1].values.data(), 200);
  const Eigen::Map<const Eigen::VectorXd> q(data.columns[0].values.data(), 200);
  at_measured << Eigen::VectorXd::Ones(200), x, x.cwiseAbs2();
  const Eigen::VectorXd expected = missed(at_measured, 1e6 * q);
  const Eigen::VectorXd found = missed(problem->base_columns, problem->outputs[0].measured);
  EXPECT_GT(expected.norm(), 60);  // 200 rows of 5 nm
  EXPECT_LT((found - expected).norm(), 1e-3 * expected.norm());
}

std::vector<std::vector<double>> thermometers(unsigned seed, double cycle_k, double noise_k) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<std::vector<double>> values(5);
  for (std::size_t i = 0; i < 300; ++i) {
    const double t_s = 400.0 * static_cast<double>(i);
    for (std::size_t j = 0; j < values.size(); ++j) {
      const auto own = static_cast<double>(j + 1);
      values[j].push_back(20 + std::sin(t_s / 30000) +
                          cycle_k * own * std::sin(2 * std::numbers::pi * t_s / 961 - 0.2 * own) +
                          noise_k * normal(random));
    }
  }
  return values;
}

std::vector<double> every_400_s() {
  std::vector<double> time_s;
  for (std::size_t i = 0; i < 300; ++i) time_s.push_back(400.0 * static_cast<double>(i));
  return time_s;
}

double rms_apart(const std::vector<double>& a, const std::vector<double>& b) {
  double squares = 0;
  for (std::size_t i = 0; i < a.size(); ++i) squares += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(squares / static_cast<double>(a.size()));
}

TEST(ThermometersTogether, KeepACycleOfTheRoomThatIsFasterThanTheSampling) {
  const auto quiet = thermometers(3, 0.01, 0), noisy = thermometers(3, 0.01, 1e-3);
  const auto smooth = smoothed_together(every_400_s(), noisy);
  for (std::size_t j = 0; j < smooth.size(); ++j) {
    const double cycle_k = 0.01 * static_cast<double>(j + 1) / std::sqrt(2.0);
    EXPECT_LT(rms_apart(smooth[j], quiet[j]), 0.15 * cycle_k) << "thermometer " << j;
    // One by one they lose it: that is why they are taken together.
    EXPECT_GT(rms_apart(smoothed(every_400_s(), noisy[j]), quiet[j]), 0.5 * cycle_k);
  }
}

TEST(ThermometersTogether, LoseTheirOwnNoiseAsEachAloneDoes) {
  const auto noisy = thermometers(4, 0, 2e-3);
  const auto smooth = smoothed_together(every_400_s(), noisy);
  for (std::size_t j = 0; j < smooth.size(); ++j)
    EXPECT_EQ(smooth[j], smoothed(every_400_s(), noisy[j])) << "thermometer " << j;
}

Diagnosis of_a_jump(double others_k) {
  Dataset data = one_axis(5, 300, 12, [](double) { return 5.0; });
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal;
  for (const char* name : {"t01", "t02", "t03"}) {
    data.columns.push_back({{name, "degC"}, {}});
    for (std::size_t i = 0; i < data.rows; ++i)
      data.columns.back().values.push_back(20 + 1e-3 * normal(random));
  }
  for (std::size_t i = 150; i < data.rows; ++i) {
    data.columns[3].values[i] += 0.05;
    data.columns[4].values[i] += others_k;
  }
  return diagnosed(data, "q1 ~ x + x^2");
}

TEST(AJumpOfOneThermometer, ThatAnotherFollowsALittleIsTheRoomsAndOnlyTold) {
  const auto found = of_a_jump(0.012);
  EXPECT_THAT(names_in(found), testing::IsEmpty());
  EXPECT_THAT(found.warnings, testing::Contains(testing::HasSubstr("Sensor t02 jumps")));
}

TEST(AJumpOfOneThermometer, ThatNoOtherFollowsIsABrokenThermometer) {
  EXPECT_THAT(names_in(of_a_jump(0)), testing::ElementsAre("sensor_fault"));
}

// Three outputs lose three times as much by chance without a column of no effect; and a level is
// told beyond the ramp that the part is on.
TEST(AJumpOfOneThermometer, InAPartThatWarmsIsToldBesideThreeOutputsToo) {
  int named = 0;
  for (unsigned seed = 40; seed < 50; ++seed) {
    Dataset data = one_axis(seed, 300, 12, [](double) { return 5.0; });
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    for (const char* name : {"q2", "q3"}) {
      data.columns.push_back({{name, "mm"}, {}});
      for (std::size_t i = 0; i < data.rows; ++i)
        data.columns.back().values.push_back(data.columns[1].values[i] + 5e-6 * normal(random));
    }
    for (const char* name : {"t01", "t02", "t03"}) {
      data.columns.push_back({{name, "degC"}, {}});
      for (std::size_t i = 0; i < data.rows; ++i)
        data.columns.back().values.push_back(20 + 0.005 * static_cast<double>(i) +
                                             1e-3 * normal(random));
    }
    for (std::size_t i = 150; i < data.rows; ++i) data.columns[5].values[i] += 0.045;
    const auto names = names_in(diagnosed(data, "q1 + q2 + q3 ~ x + T"));
    named += std::ranges::count(names, "sensor_fault") == 1 ? 1 : 0;
  }
  EXPECT_GE(named, 9);  // of 10
}

TEST(NoiseThatGrowsAlongABeam, IsWeighedRowByRow) {
  const auto grows = [](double u) { return 4 * (1 + 0.8 * (u + 1)); };  // 4 to 10.4 nm
  const Dataset data = one_axis(7, 400, 20, grows);
  const auto problem = lay_out(data, baseline_of("q1 ~ x + x^2", data), 4000);
  ASSERT_TRUE(problem);
  const Eigen::MatrixXd series = problem->series();
  const Ground ground(problem->timeline, {{0, 1}}, problem->learned(problem->base_columns), series);
  const auto spread = spread_over_places(*problem, ground);
  ASSERT_TRUE(spread);
  const Eigen::VectorXd sd = spread->sd.col(0);
  double near = 0, far = 0;
  for (std::size_t i = 0; i < data.rows; ++i) {
    const double u = data.columns[0].values[i] / 4;
    if (u < -0.99) near = sd[static_cast<Eigen::Index>(i)];
    if (u > 0.99) far = sd[static_cast<Eigen::Index>(i)];
  }
  EXPECT_NEAR(far / near, 2.6, 0.7);
  EXPECT_NEAR(sd.cwiseAbs2().mean(), 1, 1e-9);
}

TEST(NoiseThatIsTheSameEverywhere, IsHardlyEverWeighedRowByRow) {
  int weighed = 0, by_the_hour = 0;
  for (unsigned seed = 100; seed < 300; ++seed) {
    const Dataset data = one_axis(seed, 200, 20, [](double) { return 5.0; });
    const auto problem = lay_out(data, baseline_of("q1 ~ x + x^2", data), 4000);
    const Eigen::MatrixXd series = problem->series();
    const Ground ground(problem->timeline, {{0, 1}}, problem->learned(problem->base_columns),
                        series);
    weighed += spread_over_places(*problem, ground) ? 1 : 0;
    by_the_hour += spread_over_time(*problem, ground) ? 1 : 0;
  }
  EXPECT_LE(by_the_hour, 3);
  EXPECT_LE(weighed, 3);  // of 200; 1 in 1000 is meant, and 4 of 200 would be chance in 1 of 1e4
}

TEST(AJump, IsNamedInNoiseThatIsCorrelatedFromRowToRow) {
  int named = 0;
  for (unsigned seed = 20; seed < 25; ++seed) {
    Dataset data = one_axis(seed, 220, 12, [](double) { return 0.3; });
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    double slow = 0;
    for (std::size_t i = 0; i < data.rows; ++i) {
      slow = 0.5 * slow + 3 * std::sqrt(0.75) * normal(random);
      data.columns[1].values[i] += 1e-6 * (slow + (i >= 120 ? 9 : 0));
    }
    const auto names = names_in(diagnosed(data, "q1 ~ x + x^2"));
    named += names == std::vector<std::string>{"step_change"} ? 1 : 0;
  }
  EXPECT_GE(named, 4);  // of 5; the noise alone allows 2 ln L of some 90
}

// Every second line of twenty points is held out, and the jump falls into one of those: all of its
// rows lie between two that learn.
TEST(AJump, InALineThatIsHeldOutLiesWhereThatLineShowsIt) {
  constexpr std::size_t kJump = 132, kLine = 20;
  Dataset data = one_axis(31, 280, 18, [](double) { return 5.0; });
  for (std::size_t i = 0; i < data.rows; ++i)
    data.set.push_back(i / kLine % 2 == 0 ? PointSet::calibration : PointSet::validation);
  for (std::size_t i = kJump; i < data.rows; ++i) data.columns[1].values[i] += 1e-6 * 200;
  const auto found = diagnosed(data, "q1 ~ x + x^2");
  ASSERT_THAT(names_in(found), testing::ElementsAre("step_change"));
  EXPECT_EQ(found.verdict, Verdict::extended);
  const double at_s = found.findings[0].parameters.at(0).value;
  EXPECT_GT(at_s, data.time_s[kJump - 1]);
  EXPECT_LT(at_s, data.time_s[kJump]);
  EXPECT_LT(*found.outputs[0].a90_validation_after, 1.645 * 5 * 1.2);  // nm: the noise's
}

// Three outputs over 30 h: slow noise, and all of it quieter at night, down to a third.
Dataset day_and_night(unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Dataset data;
  data.rows = 360;
  for (const char* symbol : {"q1", "q2", "q3", "x", "y", "z"})
    data.columns.push_back({{symbol, "mm"}, {}});
  std::array<double, 3> slow{};
  for (std::size_t i = 0; i < data.rows; ++i) {
    const double t_s = 300.0 * static_cast<double>(i);
    data.time_s.push_back(t_s);
    const double loud = 1 + 0.5 * std::sin(2 * std::numbers::pi * t_s / 86400 + 0.7);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double at = static_cast<double>(random() % 9) - 4, keep = std::exp(-300.0 / 6000);
      slow[axis] = keep * slow[axis] + std::sqrt(0.3 * (1 - keep * keep)) * normal(random);
      data.columns[axis].values.push_back(at);
      data.columns[axis + 3].values.push_back(at * (1 + 2e-5) +
                                              5e-6 * loud * (slow[axis] + normal(random)));
    }
  }
  return data;
}

// Thirty times as loud at the ends of the axis: one step of weighing takes part of it, and the next
// one the rest.
TEST(NoiseThatGoesWithThePlace, IsToldOnceForAllThatWasWeighed) {
  Dataset data;
  data.rows = 300;
  for (const char* symbol : {"q1", "x"}) data.columns.push_back({{symbol, "mm"}, {}});
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (std::size_t i = 0; i < data.rows; ++i) {
    const double x = -4 + 8 * std::fmod(0.618034 * static_cast<double>(i), 1.0);
    data.time_s.push_back(20.0 * static_cast<double>(i));
    data.columns[0].values.push_back(x + 2e-6 * (1 + 30 * x * x / 16) * normal(random));
    data.columns[1].values.push_back(x);
  }
  const auto found = diagnosed(data, "q ~ x");
  EXPECT_EQ(found.verdict, Verdict::adequate);
  std::vector<double> ratios;
  for (const auto& said : found.warnings)
    if (const std::string begin = "the noise goes with the place: "; said.starts_with(begin))
      ratios.push_back(std::stod(said.substr(begin.size())));
  ASSERT_THAT(ratios, testing::SizeIs(1));
  EXPECT_GT(ratios[0], 5);
  EXPECT_LT(ratios[0], 31);
}

TEST(NoiseThatGoesWithTheHour, IsWeighedRowByRowAndNothingIsNamedForIt) {
  const auto found = diagnosed(day_and_night(3), "q ~ poly(x, y, z, 1)");
  EXPECT_THAT(names_in(found), testing::IsEmpty());
  EXPECT_EQ(found.verdict, Verdict::adequate);
  EXPECT_THAT(found.warnings,
              testing::Contains(testing::HasSubstr("the noise goes with the hour")));
}

TEST(NoiseThatGoesWithTheHour, IsReadOffTheSquaresOfWhatIsLeft) {
  const Dataset data = day_and_night(4);
  const auto problem = *lay_out(data, baseline_of("q ~ poly(x, y, z, 1)", data), 4000);
  Eigen::MatrixXd series(problem.timeline.rows(), 3);
  for (Eigen::Index o = 0; o < 3; ++o)
    series.col(o) = problem.learned(problem.outputs[static_cast<std::size_t>(o)].measured);
  const Ground ground(problem.timeline, noise_grid(problem.timeline),
                      problem.learned(problem.base_columns), series);
  const auto spread = spread_over_time(problem, ground);
  ASSERT_TRUE(spread.has_value());
  EXPECT_FALSE(spread_over_places(problem, ground).has_value());
  double squares = 0;
  for (std::size_t i = 0; i < data.rows; ++i) {
    const double loud = 1 + 0.5 * std::sin(2 * std::numbers::pi * data.time_s[i] / 86400 + 0.7);
    squares += std::pow(std::log(spread->sd(static_cast<Eigen::Index>(i), 0) / loud), 2);
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(data.rows)), 0.2);  // of 0.4 in the logarithm
  EXPECT_GT(spread->gain, 30);
}

// A thermometer by a door: its readings change by degrees of freedom that normal ones have not.
TEST(AJumpOfOneThermometer, ThatIsNoLargerThanItsOtherChangesHasNoName) {
  std::mt19937_64 random(12);
  std::student_t_distribution<double> student(2);
  std::vector<double> restless(400);
  for (double& change : restless) change = student(random);
  const StudentLaw law = student_law(restless, 0);
  // P(|t| > x) of two degrees of freedom: 1 - x / sqrt(x^2 + 2).
  const double far = 12 * robust_sd(restless);
  EXPECT_NEAR(std::log(law.beyond(far)), std::log(1 - far / std::sqrt(far * far + 2)), 1.0);
  // One of 400 changes as large as 12 usual ones is nothing; under the normal law it never comes.
  EXPECT_GT(chance_of_as_many(law.beyond(far), 1, 400), 0.05);
  std::normal_distribution<double> normal;
  for (double& change : restless) change = normal(random);
  EXPECT_LT(chance_of_as_many(student_law(restless, 0).beyond(12), 1, 400), 1e-3);
}

TEST(AJumpOfOneThermometer, HasAChanceThatIsNotPrintedAsZero) {
  const auto found = of_a_jump(0);
  ASSERT_EQ(found.findings.size(), 1U);
  EXPECT_GT(found.findings[0].p_adjusted, 0);
  EXPECT_LT(found.findings[0].p_adjusted, 1e-4);  // how heavy the tail is 300 changes say roughly
}

}  // namespace
}  // namespace noise_mechanisms_test
}  // namespace driftwise::diagnosis
