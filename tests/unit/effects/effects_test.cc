// Lag and rates against the exact answers for steps, ramps and parabolas, at unequal time steps.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "server/effects/effect.h"

namespace driftwise::effects {
namespace {

std::unique_ptr<EffectState> make(const std::string& name, double tau_s) {
  const std::vector<Quantity> parameters = {{tau_s, "s"}};
  return find_effect(name)->make(parameters);
}

double step(EffectState& state, double time_s, double value) {
  return state.step(time_s, std::span(&value, 1));
}

std::vector<double> unequal_times() {
  std::mt19937 random(5);
  std::vector<double> times{0};
  while (times.back() < 20000)
    times.push_back(times.back() + 1 + static_cast<double>(random() % 40));
  return times;
}

TEST(Lag, StartsInEquilibrium) { EXPECT_EQ(step(*make("lag", 1830), 1e9, 21.5), 21.5); }

TEST(Lag, FollowsARampBehindByTau) {
  const auto lag = make("lag", 1830);
  for (const double t : unequal_times()) {
    const double slope = 1e-4, expected = 20 + slope * (t - 1830 * (1 - std::exp(-t / 1830)));
    EXPECT_NEAR(step(*lag, t, 20 + slope * t), expected, 1e-12);
  }
}

TEST(Lag, DoesNotCareHowAStraightStretchIsSampled) {
  const auto coarse = make("lag", 300), fine = make("lag", 300);
  step(*coarse, 0, 20);
  step(*fine, 0, 20);
  for (int i = 1; i <= 100; ++i) step(*fine, 10.0 * i, 20 + 0.01 * i);
  EXPECT_NEAR(step(*coarse, 1000, 21), step(*fine, 1000, 21), 1e-12);
}

TEST(Rate, OfASteadyRampSettlesToIt) {
  const auto rate = make("rate", 300);
  double last = 0;
  for (const double t : unequal_times()) last = step(*rate, t, 20 + 0.5 * t / 3600);
  EXPECT_NEAR(last, 0.5, 1e-9);  // K/h
}

TEST(Rate, OfNothingIsExactlyNothing) {
  const auto rate = make("rate", 300);
  for (const double t : unequal_times()) EXPECT_EQ(step(*rate, t, 23.004), 0);
}

TEST(Rate2, OfAParabolaSettlesToItsSecondDerivative) {
  const auto rate2 = make("rate2", 300);
  double last = 0;
  for (double t = 0; t < 20000; t += 5)
    last = step(*rate2, t, 20 + 0.5 * 0.3 * (t / 3600) * (t / 3600));
  EXPECT_NEAR(last, 0.3, 1e-4);  // K/h^2; the input runs straight between readings of 5 s
}

TEST(SquareLag, AgreesWithAnIntegrationInSmallSteps) {
  // dL/dt = (u^2 - L)/tau by Euler steps of 10 ms, from equilibrium
  const double tau = 600;
  const auto heat = make("square_lag", tau);
  const auto speed = [](double t) { return 3000 + 1500 * std::sin(t / 700); };
  double lagged = std::pow(speed(0), 2), result = 0;
  for (double t = 0; t <= 2000; t += 10) result = step(*heat, t, speed(t));
  for (double t = 0; t < 2000; t += 0.01) lagged += 0.01 / tau * (std::pow(speed(t), 2) - lagged);
  EXPECT_NEAR(result, lagged, 1e-4 * lagged);
}

TEST(Rate, AgreesWithAnIntegrationInSmallSteps) {
  // dL/dt = (u - L)/tau by Euler steps of 10 ms; another method, so agreement to its own error
  const double tau = 120;
  const auto rate = make("rate", tau);
  const auto input = [](double t) { return 20 + std::sin(t / 500); };
  double lagged = input(0);
  double result = step(*rate, 0, input(0));
  for (int i = 0; i < 200000; ++i) {
    const double t = 0.01 * i;
    lagged += 0.01 / tau * (input(t) - lagged);
    if (i % 100 == 99) result = step(*rate, t + 0.01, input(t + 0.01));
  }
  EXPECT_NEAR(result, (input(2000) - lagged) / tau * 3600, 1e-3);
}

TEST(Effects, PassOverAMissingValueAndSpanTheGap) {
  const auto with_gap = make("lag", 300), without = make("lag", 300);
  step(*with_gap, 0, 20);
  step(*without, 0, 20);
  EXPECT_TRUE(std::isnan(step(*with_gap, 50, std::numeric_limits<double>::quiet_NaN())));
  EXPECT_EQ(step(*with_gap, 100, 21), step(*without, 100, 21));
}

TEST(Effects, CopiedAreIndependent) {
  const auto state = make("rate", 300);
  step(*state, 0, 20);
  step(*state, 100, 20.5);
  const auto copy = state->clone();
  step(*state, 200, 25);
  const auto again = make("rate", 300);
  step(*again, 0, 20);
  step(*again, 100, 20.5);
  EXPECT_EQ(step(*copy, 200, 21), step(*again, 200, 21));
}

TEST(Contact, IsTheLoadToTwoThirdsWithItsSign) {
  const auto contact = find_effect("contact")->make({});
  EXPECT_DOUBLE_EQ(step(*contact, 0, 8), 4);
  EXPECT_DOUBLE_EQ(step(*contact, 1, -27), -9);
  EXPECT_EQ(step(*contact, 2, 0), 0);
  EXPECT_TRUE(std::isnan(step(*contact, 3, std::nan(""))));
  for (double load = 0.1; load < 60; load *= 1.3)
    EXPECT_NEAR(step(*contact, 4, load), std::exp(2 * std::log(load) / 3), 1e-12 * load);
}

TEST(EffectsOfCoordinates, AnAngleHasItsPeriodAndItsPlayInArcseconds) {
  const auto wave = for_coordinate_in("arcsec", *checked({"sin", {"rz"}, {{0.02, "deg"}}}));
  ASSERT_TRUE(wave.has_value());
  EXPECT_EQ(wave->parameters[0].unit, "arcsec");
  EXPECT_NEAR(wave->parameters[0].value, 72, 1e-12);
  auto sine = find_effect("sin")->make(wave->parameters);
  EXPECT_NEAR(step(*sine, 0, 18), 1, 1e-12);        // a quarter of 72 arcsec
  EXPECT_NEAR(step(*sine, 1, 720 + 6), 0.5, 1e-9);  // ten turns and a twelfth
  auto play = find_effect("play")->make(std::vector<Quantity>{{4, "arcsec"}});
  EXPECT_EQ(step(*play, 0, 0), 0);
  EXPECT_EQ(step(*play, 1, 100), -2);
  EXPECT_EQ(step(*play, 2, 50), 2);
}

// The same sine of the same place, a twelfth of a period from zero, whatever the channel's unit.
TEST(EffectsOfCoordinates, APeriodIsReadInTheUnitOfTheChannel) {
  const struct {
    const char* channel;
    double place;
    Quantity period;
  } cases[] = {{"m", 1e-6, {12, "um"}},          {"mm", 0.001, {12000, "nm"}},
               {"um", 1, {0.012, "mm"}},         {"nm", 1000, {12, "um"}},
               {"nm", 1000, {12000, "nm"}},      {"deg", 30, {360, "deg"}},
               {"deg", 30, {1296000, "arcsec"}}, {"rad", std::numbers::pi / 6, {360, "deg"}},
               {"arcsec", 3, {0.01, "deg"}}};
  for (const auto& one : cases) {
    const auto call = for_coordinate_in(one.channel, *checked({"sin", {"q1"}, {one.period}}));
    ASSERT_TRUE(call.has_value()) << one.channel;
    const auto again = for_coordinate_in(one.channel, *checked(*call));
    EXPECT_EQ(*again, *call) << one.channel;
    auto sine = find_effect("sin")->make(call->parameters);
    EXPECT_NEAR(step(*sine, 0, one.place), 0.5, 1e-9) << one.channel << " " << one.period.unit;
  }
}

TEST(EffectsOfCoordinates, APeriodOfTheWrongKindIsToldWithTheUnitThatIsExpected) {
  EXPECT_TRUE(for_coordinate_in("arcsec", {"sin", {"rz"}, {{72, "arcsec"}}}).has_value());
  EXPECT_EQ(for_coordinate_in("arcsec", {"sin", {"rz"}, {{72, "nm"}}}).error().message,
            "its period is in nm, expected arcsec as the channel is in arcsec");
  EXPECT_EQ(for_coordinate_in("degC", {"sin", {"t04"}, {{72, "nm"}}}).error().message,
            "expected a channel of lengths (m, mm, um, nm) or angles (rad, deg, arcsec)");
  EXPECT_EQ(output_unit(*find_effect("heat"), "arcsec"), "arcsec/s");
  EXPECT_EQ(output_unit(*find_effect("heat"), "mm"), "mm/s");
  EXPECT_EQ(output_unit(*find_effect("play"), "um"), "um");
}

}  // namespace
}  // namespace driftwise::effects
