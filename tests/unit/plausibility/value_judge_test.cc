#include "server/plausibility/value_judge.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "server/plausibility/frozen_in_motion.h"
#include "tests/unit/plausibility/cells.h"

namespace driftwise::plausibility {
namespace {

std::string test_of(const JudgedReading& reading, const std::string& channel) {
  for (const auto& one : reading.rejected)
    if (one.channel == channel) return one.test;
  return "";
}

class Judge : public testing::Test {
 protected:
  std::string say(double time_s, double t01_degc) {
    auto reading = scan(time_s, {t01_degc, 20 + 1e-3 * std::sin(time_s), 20.2, 20.3});
    judge.judge(reading);
    return test_of(reading, "t01_degC");
  }
  CellDescription description = cell();
  ValueJudge judge{description};
};

// A cell with a stabilised support; the room's first thermometer stands beside it.
class SupportedCell {
 public:
  SupportedCell() {
    DeviceDescription support;
    support.id = "support";
    support.become<StabiliserSettings>();
    description_.devices.push_back(support);
  }
  std::string says(double degc, double set_degc, double room_degc) {
    time_s_ += 10;
    auto room = scan(time_s_, {room_degc, 20.1, 20.2, 20.3});
    judge_.judge(room);
    JudgedReading reading;
    reading.device = "support";
    reading.start = reading.end = at_s(time_s_);
    reading.values = {{"support_degC", degc}, {"support_set_degC", set_degc}};
    judge_.judge(reading);
    return test_of(reading, "support_degC");
  }

 private:
  CellDescription description_ = cell();
  ValueJudge judge_{description_};
  double time_s_ = 0;
};

struct Impossible {
  const char* name;
  double value;
  const char* test;
};
class ImpossibleValue : public Judge, public testing::WithParamInterface<Impossible> {};
TEST_P(ImpossibleValue, IsRejectedAndTheOthersAreNot) {
  EXPECT_EQ(say(0, 20.0), "");
  auto reading = scan(10, {GetParam().value, 20.1, 20.2, 20.3});
  const auto findings = judge.judge(reading);
  EXPECT_EQ(test_of(reading, "t01_degC"), GetParam().test);
  EXPECT_EQ(reading.rejected.size(), 1U);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings.front().device, "scanner");
  EXPECT_EQ(say(20, 20.0), "") << "the false value is no base for the next";
}
INSTANTIATE_TEST_SUITE_P(
    Table, ImpossibleValue,
    testing::Values(Impossible{"nan", kNan, "missing"}, Impossible{"inf", INFINITY, "not_finite"},
                    Impossible{"minus_inf", -INFINITY, "not_finite"},
                    Impossible{"huge", 1e308, "range"}, Impossible{"hot", 500, "range"},
                    Impossible{"inverted", -20, "range"}, Impossible{"step", 20.5, "step"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST_F(Judge, AStepStaysInDoubtUntilItStepsBack) {
  EXPECT_EQ(say(0, 20.00), "");
  EXPECT_EQ(say(10, 20.30), "step");
  // The room goes on drifting meanwhile, farther than the step.
  for (int k = 2; k < 200; ++k) EXPECT_EQ(say(10 * k, 20.30 + 0.005 * k), "step") << k;
  EXPECT_EQ(say(2000, 21.00), "");
}

TEST_F(Judge, AStepBackMayBeALittleSmallerThanTheStep) {
  EXPECT_EQ(say(0, 20.00), "");
  EXPECT_EQ(say(10, 20.26), "step");
  EXPECT_EQ(say(20, 20.02), "");
  EXPECT_EQ(say(30, 20.02), "");
}

TEST_F(Judge, AThawedChannelMayBeFarFromWhereItFroze) {
  int k = 0;
  for (; k < 30; ++k) EXPECT_EQ(say(10 * k, 20 + 1e-3 * (3 * k % 7)), "") << k;
  for (int frozen = 0; frozen < 360; ++frozen, ++k) say(10 * k, 20.0005);
  EXPECT_EQ(say(10 * k, 20.0005), "frozen");
  EXPECT_EQ(say(10 * k + 10, 20.9), "") << "the room went on for an hour";
  EXPECT_EQ(say(10 * k + 20, 20.901), "");
}

TEST_F(Judge, APersonTakesTheNewLevelAsRight) {
  say(0, 20.0);
  EXPECT_EQ(say(10, 20.3), "step");
  judge.begin_anew();
  EXPECT_EQ(say(20, 20.3), "");
  EXPECT_EQ(say(30, 20.3), "");
}

TEST_F(Judge, AProbeMayDriftAsFastAsAMachineWarms) {
  for (int k = 0; k < 100; ++k) EXPECT_EQ(say(10 * k, 20 + 0.04 * k), "") << k;  // 14 K/h
}

TEST_F(Judge, AirMayStepFartherThanAPart) {
  auto reading = scan(0, {20, 20, 20, 20});
  judge.judge(reading);
  reading = scan(10, {20, 20, 20, 21.9});
  judge.judge(reading);
  EXPECT_TRUE(reading.rejected.empty());
}

TEST_F(Judge, AllProbesThatStepTogetherAreTheScanner) {
  auto reading = scan(0, {20, 20.1, 20.2, 20.3});
  judge.judge(reading);
  reading = scan(10, {20.1, 20.2, 20.3, 20.4});
  const auto findings = judge.judge(reading);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings.front().test, "together");
  EXPECT_EQ(reading.rejected.size(), 4U);
  reading = scan(20, {20.1, 20.2, 20.3, 20.4});
  judge.judge(reading);
  EXPECT_EQ(reading.rejected.size(), 4U) << "it has not stepped back";
  reading = scan(30, {20, 20.1, 20.2, 20.3});
  judge.judge(reading);
  EXPECT_TRUE(reading.rejected.empty());
}

TEST_F(Judge, ProbesThatDisagreeDoNotStepTogether) {
  auto reading = scan(0, {20, 20.1, 20.2, 20.3});
  judge.judge(reading);
  reading = scan(10, {20.1, 20.2, 20.1, 20.4});
  judge.judge(reading);
  EXPECT_TRUE(reading.rejected.empty());
}

TEST_F(Judge, AFrozenValueIsFoundByTheChannelsOwnNoise) {
  int k = 0;
  for (; k < 30; ++k) EXPECT_EQ(say(10 * k, 20 + 1e-3 * (3 * k % 7)), "") << k;
  int frozen_after = 0;
  while (say(10 * ++k, 20.0005) == "" && ++frozen_after < 100) {
  }
  EXPECT_EQ(frozen_after, kFewestEqual - 1);
  EXPECT_EQ(say(10 * ++k, 20.0005), "frozen");
  EXPECT_EQ(say(10 * ++k, 20.0015), "");
}

// An air probe of 0.01 K with noise of 2 to 20 mK in a room that drifts slowly: rows are short at
// the edge of a step and long in its middle. Limits from the longest row alone, and coarse by the
// mean row alone, judged up to 71 of 200 such channels frozen within 600 answers.
TEST_F(Judge, AChannelOfLargeStepsInASlowRoomIsNotFrozen) {
  for (const double noise_k : {0.002, 0.003, 0.005, 0.01, 0.02})
    for (const double drift_k : {1e-5, 3e-5, 1e-4, 3e-4})
      for (unsigned seed = 1; seed <= 40; ++seed) {
        ValueJudge fresh(description);
        std::mt19937 random(seed);
        std::normal_distribution<double> noise(0, noise_k);
        const double start = 20 + 1e-4 * (seed % 100);
        for (int k = 0; k < 600; ++k) {
          const double degc = std::round(100 * (start + drift_k * k + noise(random))) / 100;
          auto reading = scan(10 * k, {degc, 20.1, 20.2, 20.3});
          fresh.judge(reading);
          ASSERT_NE(test_of(reading, "t01_degC"), "frozen")
              << noise_k << " K of noise, " << drift_k << " K per answer, seed " << seed;
        }
      }
}

TEST_F(Judge, AChannelThatOftenRepeatsItselfIsFoundFrozenByItsRate) {
  std::mt19937 random(7);
  std::bernoulli_distribution changes(0.25);
  double degc = 20;
  const std::array steps = {1, -3, 5, -4, 2};  // more than one: its noise shows
  int k = 0, change = 0;
  for (; k < 600; ++k)
    EXPECT_EQ(say(10 * k, degc += changes(random) ? 0.001 * steps[++change % 5] : 0), "") << k;
  int frozen_after = 0;
  while (say(10 * ++k, degc) == "" && ++frozen_after < 1000) {
  }
  EXPECT_LT(frozen_after, 100);  // 1e-9 by chance: 72 answers at 3 in 4
  EXPECT_GT(frozen_after, 60);
}

// A controller that shows hundredths repeats itself, and longest where the room turns round: it is
// frozen when its neighbours move and it does not.
TEST_F(Judge, ACoarseChannelIsFrozenOnlyWhileOthersMove) {
  const auto say_with = [this](double time_s, double degc, double neighbour_degc) {
    auto reading = scan(time_s, {degc, neighbour_degc, 20.2, 20.3});
    judge.judge(reading);
    return test_of(reading, "t01_degC");
  };
  int k = 0;
  for (int block = 0; block < 36; ++block)
    for (int same = 0; same < 12; ++same)
      EXPECT_EQ(say_with(10 * ++k, 20 + 0.01 * (block % 3), 20.1), "") << block;
  for (int same = 0; same < 500; ++same)
    EXPECT_EQ(say_with(10 * ++k, 20.05, 20.1 + 1e-4 * (same % 9)), "") << "the room turns round";
  double neighbour_degc = 20.1;
  while (neighbour_degc < 20.14)
    EXPECT_EQ(say_with(10 * ++k, 20.05, neighbour_degc += 0.01), "") << neighbour_degc;
  say_with(10 * ++k, 20.05, 20.16);
  EXPECT_EQ(say_with(10 * ++k, 20.05, 20.16), "frozen") << "0.05 K while its own step is 0.01 K";
}

// From switching on a held support goes one way, a new number in each answer, and then shows its
// set point for days while the room moves.
TEST_F(Judge, ASupportThatReachedItsSetPointStandsStill) {
  SupportedCell supported;
  double degc = 17;
  for (; degc < 19.995; degc += 0.03) EXPECT_EQ(supported.says(degc, 20, 22), "");
  for (int k = 0; k < 5000; ++k)
    ASSERT_EQ(supported.says(20, 20, 22 + 1e-3 * k), "") << k << " answers after the ramp";
}

// At a set point between two of its hundredths a support flickers; at one in the middle of a
// hundredth it stands still.
TEST_F(Judge, ASupportIsFrozenOnlyWhileItsSetPointMoves) {
  SupportedCell supported;
  std::mt19937 random(3);
  std::bernoulli_distribution upper(0.5);
  for (int k = 0; k < 300; ++k)
    ASSERT_EQ(supported.says(upper(random) ? 20.01 : 20, 20.005, 22), "") << k;
  for (int k = 0; k < 2000; ++k)
    ASSERT_EQ(supported.says(20, 20, 22 + 1e-3 * k), "") << "only the room moved, " << k;
  int still = 0;
  while (supported.says(20, 20.5, 24) == "" && ++still < 1000) {
  }
  EXPECT_GE(still, kFewestEqual - 1) << "it follows its set point with a lag";
  EXPECT_LT(still, 100);
}

TEST_F(Judge, AChannelThatNeverChangedIsNotJudged) {
  for (int k = 0; k < 1000; ++k) EXPECT_EQ(say(10 * k, 20.0), "");
}

TEST_F(Judge, ADeclaredLimitGoesBeforeTheDefault) {
  description.plausibility.limits.push_back({"t01_degC", 18.0, 22.0, 1.0, 0.0, 3});
  ValueJudge strict(description);
  const auto say_to = [&strict](double time_s, double degc) {
    auto reading = scan(time_s, {degc, 20.1, 20.2, 20.3});
    strict.judge(reading);
    return test_of(reading, "t01_degC");
  };
  EXPECT_EQ(say_to(0, 20.0), "");
  EXPECT_EQ(say_to(10, 20.9), "");
  EXPECT_EQ(say_to(20, 22.5), "range");
  EXPECT_EQ(say_to(30, 20.8), "");
  EXPECT_EQ(say_to(40, 20.8), "");
  EXPECT_EQ(say_to(50, 20.8), "frozen");
}

TEST_F(Judge, ALengthMayNotBeFasterThanTheAxes) {
  auto reading = length(0, 0);
  judge.judge(reading);
  reading = length(1, 4.9);  // ten times the axes' 5 mm/s
  judge.judge(reading);
  EXPECT_TRUE(reading.rejected.empty());
  reading = length(1.1, 400);
  judge.judge(reading);
  EXPECT_EQ(test_of(reading, "x_mm"), "step");
}

TEST(FrozenInMotion, TheSameNumberFromTwoPlacesIsFrozen) {
  FrozenInMotion frozen;
  EXPECT_FALSE(frozen.is_frozen("x_mm", 1.25, {1.0}));
  EXPECT_FALSE(frozen.is_frozen("x_mm", 1.25, {1.0 + 5e-5})) << "held within its noise";
  EXPECT_TRUE(frozen.is_frozen("x_mm", 1.25, {2.0}));
  EXPECT_TRUE(frozen.is_frozen("x_mm", 1.25, {2.0}));
  EXPECT_FALSE(frozen.is_frozen("x_mm", 2.25, {2.0}));
}

TEST(ValueJudgeOfTwo, JudgesInstrumentsOfOneCoordinateEachByItself) {
  auto description = cell();
  auto touch = description.devices[1];
  touch.id = "touch";
  description.devices.push_back(touch);
  ValueJudge judge(description);
  auto near = length(0, 0);
  judge.judge(near);
  auto far = length(0.1, 400);  // another zero: no step of either
  far.device = "touch";
  judge.judge(far);
  EXPECT_EQ(test_of(far, "x_mm"), "");
  judge.begin_anew("touch");  // not the other one
  auto jumped = length(0.2, 400);
  judge.judge(jumped);
  EXPECT_EQ(test_of(jumped, "x_mm"), "step");
}

}  // namespace
}  // namespace driftwise::plausibility
