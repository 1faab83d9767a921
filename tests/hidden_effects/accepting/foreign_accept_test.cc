// The judgement of accepted findings at the truth of the independent population: its frame, its
// rules, and one data set of it from end to end.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <map>

#include "server/core/units.h"
#include "server/formats/csv/dataset_csv.h"
#include "tests/hidden_effects/accepting/foreign_case.h"
#include "tests/hidden_effects/accepting/foreign_report.h"
#include "tests/hidden_effects/accepting/foreign_truth.h"
#include "tests/hidden_effects/foreign/dataset.h"

namespace driftwise::hidden {
namespace {

constexpr CellTime kAnyZero{1'700'000'000'000'000'000};
// An rms over correlated errors of a fit scatters: three of its expectation is beyond chance.
constexpr double kBeyondChance = 3.0;

// The reference laboratory: lattice, white noise, six thermometers.
foreign::Generated reference_set(const std::string& kind, const std::string& cause,
                                 std::uint64_t seed) {
  foreign::Order order;
  order.seed = seed;
  order.kind = kind;
  order.cause = cause;
  order.vary = "none";
  order.units = "study";
  return foreign::generate(order);
}

Dataset table_of(const foreign::Generated& made) {
  return *formats::read_dataset_csv(foreign::dataset_csv(made, foreign::dress_of(made)), "set.csv");
}

// Of a least-squares fit whose terms are the true law: sigma times the root of the judged rows'
// mean leverage. In standard deviations of one reading.
double expected_rms(const foreign::Generated& made) {
  const Eigen::MatrixXd design = made.campaign.design(made.read);
  const Eigen::MatrixXd learnt = design(made.campaign.calibration, Eigen::all);
  const Eigen::MatrixXd judged = design(made.campaign.validation, Eigen::all);
  const Eigen::MatrixXd weights =
      learnt.transpose().completeOrthogonalDecomposition().solve(judged.transpose());
  return std::sqrt(weights.squaredNorm() / static_cast<double>(judged.rows()));
}

// Rms error of the baseline's target over its expectation, of the worst output.
double worst_over_expected(const foreign::Generated& made, const Dataset& data) {
  const auto baseline = foreign::baseline_formula(made, foreign::dress_of(made));
  const auto truth = foreign_truth(made, data, kAnyZero, UnlistedEffectOf::robot);
  const auto errors =
      served_errors(accepted_fit(data, baseline).value(), CellDescription{}, data, truth).value();
  double worst = 0;
  for (std::size_t o = 0; o < errors.nm.size(); ++o)
    worst = std::max(
        worst, rms_of(errors.nm[o]) / nm_from_mm(made.campaign.robot.sigma[static_cast<int>(o)]));
  return worst / expected_rms(made);
}

TEST(ServedAtTheTruth, IsWithinTheFitsOwnNoiseWhereNothingIsHidden) {
  for (std::uint64_t seed = 3600001; seed <= 3600008; ++seed) {
    const auto made = reference_set("null", "", seed);
    EXPECT_LT(worst_over_expected(made, table_of(made)), kBeyondChance) << seed;
  }
}

// The correction as it would be with the cause known: what the instruments add, counted from the
// datum's zero as the correction stage counts.
TEST(ServedAtTheTruth, IsAsGoodWhereAnInstrumentsErrorIsTakenOutAsItWasPutIn) {
  for (const char* cause :
       {"cyclic_error", "periodic_disturbance", "instrument_drift", "refractive_index"})
    for (std::uint64_t seed = 3600011; seed <= 3600014; ++seed) {
      const auto made = reference_set("single", cause, seed);
      if (made.instrument_error.isZero(0)) continue;  // a wave of the scale is the robot's
      auto data = table_of(made);
      for (int j = 0; j < made.campaign.robot.axes; ++j)
        for (auto& column : data.columns)
          if (column.channel.symbol == made.campaign.robot.pose[static_cast<std::size_t>(j)])
            for (std::size_t row = 0; row < data.rows; ++row)
              column.values[row] -=
                  made.instrument_error(static_cast<Eigen::Index>(row), j) - made.error_at_zero[j];
      EXPECT_LT(worst_over_expected(made, data), kBeyondChance) << cause << " " << seed;
    }
}

TEST(ServedAtTheTruth, IsWorseWhereAnInstrumentJumpsAndNobodyKnows) {
  const auto made = reference_set("single", "step_change", 3600021);
  EXPECT_GT(worst_over_expected(made, table_of(made)), kBeyondChance);
}

TEST(AcceptedOnForeignData, ATermThatTheRobotLacksMakesTheTargetBetter) {
  NumberedOrder ordered;
  ordered.order.seed = 3600031;
  ordered.order.kind = "single";
  ordered.order.cause = "geometry_order";
  ordered.order.vary = "none";
  ordered.order.units = "study";
  const auto one = judged_case(ordered, 49);
  ASSERT_EQ(one.outcome, "accepted") << one.message;
  EXPECT_TRUE(one.named_right);
  EXPECT_LT(ratio_of(one.outputs), 1.0);
  EXPECT_FALSE(has_harm(one.outputs));
  EXPECT_EQ(json_line(case_of_line(json_line(one))), json_line(one));
  EXPECT_THAT(accepting_report({one}), testing::HasSubstr("Worse by more than 5 % and 1 nm in an "
                                                          "output: 0 of 1"));
}

TEST(WithheldRows, AreAFifthInFiveBlocksTheLastAtTheEnd) {
  Dataset data;
  data.rows = 100;
  withhold_rows(data);
  std::vector<std::size_t> out;
  for (std::size_t row = 0; row < data.rows; ++row)
    if (data.is_excluded(row)) out.push_back(row);
  EXPECT_THAT(out, testing::ElementsAre(16, 17, 18, 19, 36, 37, 38, 39, 56, 57, 58, 59, 76, 77, 78,
                                        79, 96, 97, 98, 99));
}

TEST(Harm, IsMoreThanFivePerCentAndMoreThanANanometre) {
  EXPECT_FALSE(is_harmed(10, 10.9));
  EXPECT_TRUE(is_harmed(10, 11.1));
  EXPECT_FALSE(is_harmed(100, 104.9));
  EXPECT_TRUE(is_harmed(100, 105.1));
  EXPECT_FALSE(is_harmed(100, 50));
}

TEST(MeanRatio, HasStudentsIntervalOnTheLogarithms) {
  // By hand: logarithms -ln 2 and ln 2, standard error ln 2, t(1, 0.975) = 12.7062.
  const auto mean = mean_ratio({0.5, 2.0}, 0.95);
  EXPECT_NEAR(mean.mean, 1.0, 1e-12);
  EXPECT_NEAR(std::log(mean.high), 12.7062 * std::log(2.0), 1e-4);
  EXPECT_NEAR(std::log(mean.low), -12.7062 * std::log(2.0), 1e-4);
}

TEST(OrdersOfACount, HaveTheMixOfTheJudgesPairedSize) {
  const auto orders = paired_orders(5000, 2);
  ASSERT_EQ(orders.size(), 2 * 276U);
  std::map<std::string, int> kinds;
  for (const auto& one : orders) {
    EXPECT_EQ(one.order.seed, 5000U + static_cast<std::uint64_t>(one.number));
    ++kinds[one.order.kind];
  }
  EXPECT_THAT(kinds, testing::UnorderedElementsAre(
                         testing::Pair("null", 240), testing::Pair("single", 184),
                         testing::Pair("pair", 56), testing::Pair("unlisted", 72)));
}

}  // namespace
}  // namespace driftwise::hidden
