#include <random>

#include "drivers/pi_gcs/pi_gcs.h"
#include "tests/unit/drivers/driver_fixture.h"

namespace driftwise {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using tests::expect;
using tests::hang_up;
using tests::Script;
using tests::send;

class GcsLoop : public tests::DriverFixture {
 protected:
  DeviceDescription axis(std::map<std::string, std::string> options = {}) {
    auto out = device("axis", "pi-gcs");
    out.become<MotionSettings>().axes.push_back({{"q1", "mm"}, "X", -2, 2, 5});
    out.options = std::move(options);
    out.options.emplace("home_poll_s", "0.005");
    out.options.emplace("start_delay_s", "0");
    return out;
  }
  MotionController& make(const DeviceDescription& description) {
    auto made = drivers::make_pi_gcs(description, context.get_executor(), clock);
    EXPECT_TRUE(made) << made.error().message;
    controller = std::move(*made);
    return *controller;
  }
  static Script operator_plus(Script a, const Script& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
  }
  static Script set_up_and(const Script& rest, const char* referenced = "X=1\n",
                           const char* servo = "X=1\n") {
    return operator_plus(
        {expect("*IDN?\n"), send("(c) PI, C-887, 1, 2.1\n"), expect("ERR?\n"), send("0\n"),
         expect("SVO?\n"), send(servo), expect("SAI?\n"), send("X \nY\n"), expect("TMN?\n"),
         send("X=-3 \nY=-3\n"), expect("TMX?\n"), send("X=3 \nY=3\n"), expect("FRF?\n"),
         send(referenced)},
        rest);
  }
  static Script state(const char* mask, const char* on_target, const char* position) {
    return {expect("\x05"),  send(mask),       expect("ONT?\n"),
            send(on_target), expect("POS?\n"), send(position)};
  }
  // At the end of a motion, and wherever an axis at rest is off its target.
  static Script state_and_why(const char* on_target, const char* position,
                              const char* error = "0\n", const char* servo = "X=1\n") {
    return operator_plus(state("0\n", on_target, position),
                         {expect("ERR?\n"), send(error), expect("SVO?\n"), send(servo)});
  }
  static Script no_error_before() { return {expect("ERR?\n"), send("0\n")}; }
  Result<void> move(double q_mm) {
    const std::vector<double> target{q_mm};
    return run(controller->start_move(target));
  }

  std::unique_ptr<MotionController> controller;
};

TEST_F(GcsLoop, SetsItsDeviceUpOnceAndReadsItsState) {
  peer.on_connection(set_up_and(
      operator_plus(state("0\n", "X=1\n", "X=0.5\n"), state("1\n", "X=0\n", "X=0.6\n"))));
  make(axis());
  ASSERT_TRUE(run(controller->prepare()));
  ASSERT_TRUE(run(controller->prepare()));
  EXPECT_EQ(controller->health().identity, "(c) PI, C-887, 1, 2.1");
  const auto rest = run(controller->state());
  ASSERT_TRUE(rest) << rest.error().message;
  EXPECT_THAT(rest->q_mm, ElementsAre(0.5));
  EXPECT_TRUE(rest->on_target && rest->referenced && !rest->moving);
  const auto moving = run(controller->state());
  EXPECT_TRUE(moving->moving && !moving->on_target);
}

TEST_F(GcsLoop, AsksEverythingInOneMessageWhenPipelining) {
  peer.on_connection({expect("*IDN?\n"), send("PI\n"), expect("ERR?\n"), send("0\n"),
                      expect("SVO?\n"), send("X=1\n"), expect("SAI?\n"), send("X\n"),
                      expect("TMN?\nTMX?\n"), send("X=-3\nX="), send("3\n"), expect("FRF?\n"),
                      send("X=1\n"), expect("\x05ONT?\nPOS?\n"), send("0\nX=1\n"), send("X=0.25\n"),
                      expect("ERR?\nMOV X 1\nERR?\n"), send("0\n0\n")});
  make(axis({{"pipelining", "on"}}));
  const auto now = run(controller->state());
  ASSERT_TRUE(now) << now.error().message;
  EXPECT_THAT(now->q_mm, ElementsAre(0.25));
  EXPECT_TRUE(move(1));
  EXPECT_TRUE(peer.finished());
}

TEST_F(GcsLoop, LearnsFromTheStatusWordWhenToldTo) {
  peer.on_connection({expect("*IDN?\n"), send("PI\n"), expect("ERR?\n"), send("0\n"),
                      expect("SVO?\n"), send("X=1\n"), expect("SAI?\n"), send("X\n"),
                      expect("\x04"), send("0x10000\n"), expect("\x05"), send("0\n"),
                      expect("ONT?\n"), send("X=1\n"), expect("POS?\n"), send("X=0\n")});
  make(axis({{"referenced_by", "status"}, {"travel_query", "off"}}));
  EXPECT_TRUE(run(controller->state())->referenced);
}

TEST_F(GcsLoop, RefusesSoftLimitsBeyondTheTravel) {
  auto wide = axis();
  wide.become<MotionSettings>().axes[0].max_mm = 3.5;
  peer.on_connection({expect("*IDN?\n"), send("PI\n"), expect("ERR?\n"), send("0\n"),
                      expect("SVO?\n"), send("X=1\n"), expect("SAI?\n"), send("X\n"),
                      expect("TMN?\n"), send("X=-3\n"), expect("TMX?\n"), send("X=3\n")});
  const auto done = run(make(wide).prepare());
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().reason, "LIMITS_BEYOND_TRAVEL");
  EXPECT_THAT(done.error().message,
              AllOf(HasSubstr("q1_mm"), HasSubstr("-2 .. 3.5"), HasSubstr("-3 .. 3 mm")));
}

TEST_F(GcsLoop, RefusesAnAxisTheControllerDoesNotHave) {
  peer.on_connection({expect("*IDN?\n"), send("PI\n"), expect("ERR?\n"), send("0\n"),
                      expect("SVO?\n"), send("X=1\n"), expect("SAI?\n"), send("1\n")});
  EXPECT_EQ(run(make(axis()).prepare()).error().reason, "UNKNOWN_AXIS");
}

TEST_F(GcsLoop, SaysWhichOptionHelpsWhenTheTravelIsNotAnswered) {
  peer.on_connection({expect("*IDN?\n"), send("PI\n"), expect("ERR?\n"), send("0\n"),
                      expect("SVO?\n"), send("X=1\n"), expect("SAI?\n"), send("X\n"),
                      expect("TMN?\n")});
  const auto done = run(make(axis()).prepare());
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, ErrorCode::deadline_exceeded);
  EXPECT_THAT(done.error().message, HasSubstr("travel_query"));
}

TEST_F(GcsLoop, MovesWithOneCommandAndAsksForItsVerdict) {
  peer.on_connection(set_up_and(operator_plus(
      no_error_before(),
      {expect("MOV X 1.25\nERR?\n"), send("0\n"), expect("MOV X 1.5\nERR?\n"), send("5\n"),
       expect("SVO?\n"), send("X=1\n"), expect("FRF?\n"), send("X=0\n")})));
  make(axis());
  EXPECT_TRUE(move(1.25));
  const auto refused = move(1.5);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "NOT_REFERENCED");
  EXPECT_THAT(refused.error().message,
              AllOf(HasSubstr("axis"), HasSubstr(peer.address()), HasSubstr("MOV X 1.5")));
}

// Error 5 has two meanings; the controller is asked which of them holds.
TEST_F(GcsLoop, SaysThatTheServoIsOffWhereTheReferenceIsKept) {
  peer.on_connection(set_up_and(operator_plus(
      operator_plus(no_error_before(), {expect("MOV X 1\nERR?\n"), send("5\n"), expect("SVO?\n"),
                                        send("X=0\n"), expect("FRF?\n"), send("X=1\n")}),
      state_and_why("X=1\n", "X=0\n", "0\n", "X=0\n"))));
  make(axis());
  const auto refused = move(1);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "SERVO_OFF");
  EXPECT_THAT(refused.error().message, AllOf(HasSubstr("servo is off"), HasSubstr("MOV X 1")));
  const auto now = run(controller->state());
  ASSERT_TRUE(now) << now.error().message;
  EXPECT_TRUE(now->referenced) << "FRF? says so";
  EXPECT_FALSE(now->servo_on);
  EXPECT_FALSE(now->on_target);
  EXPECT_TRUE(peer.finished());
}

TEST_F(GcsLoop, DoesNotTakeAnErrorOfBeforeForItsAnswer) {
  peer.on_connection(set_up_and(operator_plus(
      {expect("ERR?\n"), send("7\n"), expect("MOV X 1\nERR?\n"), send("0\n")},
      operator_plus(state("1\n", "X=0\n", "X=0.4\n"), state("1\n", "X=0\n", "X=0.6\n")))));
  make(axis());
  const auto accepted = move(1);
  ASSERT_TRUE(accepted) << accepted.error().message;
  const auto now = run(controller->state());
  ASSERT_TRUE(now) << now.error().message;
  EXPECT_THAT(now->old_error, AllOf(HasSubstr("7"), HasSubstr("before MOV X 1")));
  EXPECT_EQ(run(controller->state())->old_error, "") << "told once";
  EXPECT_TRUE(peer.finished());
}

// A controller that halts an axis at a limit switch may be on target: of where it halted.
TEST_F(GcsLoop, AsksWhyAMotionEndedAndKeepsTheAnswerUntilTheNextOne) {
  peer.on_connection(set_up_and(operator_plus(
      operator_plus(no_error_before(), {expect("MOV X 1.5\nERR?\n"), send("0\n")}),
      operator_plus(
          operator_plus(state("1\n", "X=0\n", "X=0.4\n"),
                        state_and_why("X=1\n", "X=1.2\n", "1024\n")),
          operator_plus(operator_plus(state("0\n", "X=1\n", "X=1.2\n"), no_error_before()),
                        operator_plus({expect("MOV X 1\nERR?\n"), send("0\n")},
                                      state_and_why("X=1\n", "X=1\n")))))));
  make(axis());
  ASSERT_TRUE(move(1.5));
  EXPECT_EQ(run(controller->state())->halted_because, "") << "on its way";
  const auto halted = run(controller->state());
  ASSERT_TRUE(halted) << halted.error().message;
  EXPECT_THAT(halted->halted_because, HasSubstr("1024"));
  EXPECT_THAT(halted->old_error, AllOf(HasSubstr("1024"), HasSubstr("end of a motion")));
  EXPECT_THAT(run(controller->state())->halted_because, HasSubstr("1024"));
  ASSERT_TRUE(move(1));
  EXPECT_EQ(run(controller->state())->halted_because, "");
  EXPECT_TRUE(peer.finished());
}

// An emergency stop switches the servo off, and the connection breaks.
TEST_F(GcsLoop, NeverSwitchesAServoOnByItself) {
  peer.on_connection(set_up_and(operator_plus(state("0\n", "X=1\n", "X=1\n"), {hang_up()})));
  peer.on_connection(
      set_up_and(state_and_why("X=0\n", "X=0.9\n", "0\n", "X=0\n"), "X=1\n", "X=0\n"));
  make(axis());
  ASSERT_TRUE(run(controller->state())->servo_on);
  let_pass(20ms);
  const auto now = run(controller->state());
  ASSERT_TRUE(now) << now.error().message;
  EXPECT_FALSE(now->servo_on);
  EXPECT_TRUE(now->referenced);
  EXPECT_TRUE(peer.finished());
  EXPECT_THAT(peer.problems(), testing::IsEmpty()) << "no SVO X 1 was sent";
}

TEST_F(GcsLoop, SendsNothingOutsideTheSoftLimits) {
  make(axis());
  for (const double q_mm : {2.0001, -2.0001, std::numeric_limits<double>::quiet_NaN(),
                            std::numeric_limits<double>::infinity()}) {
    const auto refused = move(q_mm);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().reason, "SOFT_LIMIT");
  }
  const std::vector<double> two{0, 0};
  EXPECT_EQ(run(controller->start_move(two)).error().reason, "WRONG_COUNT");
  EXPECT_EQ(peer.connections(), 0);
}

TEST_F(GcsLoop, CountsAMoveAsUnderWayBeforeItHasStarted) {
  const auto still = state("0\n", "X=1\n", "X=0\n");
  peer.on_connection(set_up_and(
      operator_plus(operator_plus(no_error_before(), {expect("MOV X 1\nERR?\n"), send("0\n")}),
                    operator_plus(still, state_and_why("X=1\n", "X=0\n")))));
  make(axis({{"start_delay_s", "0.1"}}));
  ASSERT_TRUE(move(1));
  const auto at_once = run(controller->state());
  EXPECT_TRUE(at_once->moving && !at_once->on_target)
      << "the controller still speaks of the old target";
  let_pass(110ms);
  EXPECT_FALSE(run(controller->state())->moving);
}

class Homing : public GcsLoop, public testing::WithParamInterface<const char*> {};
TEST_P(Homing, EndsWhenTheAxisIsReferenced) {
  const std::string command = std::string(GetParam()) + " X\nERR?\n";
  const auto look = [](const char* referenced, const Script& now) {
    return operator_plus({expect("FRF?\n"), send(referenced)}, now);
  };
  peer.on_connection(set_up_and(
      operator_plus(operator_plus(no_error_before(), {expect("SVO X 1\nERR?\n"), send("0\n"),
                                                      expect(command), send("0\n")}),
                    operator_plus(look("X=0\n", state("1\n", "X=0\n", "X=1\n")),
                                  operator_plus(look("X=0\n", state_and_why("X=0\n", "X=0.1\n")),
                                                look("X=1\n", state("0\n", "X=1\n", "X=0\n"))))),
      "X=0\n", "X=0\n"));
  make(axis({{"reference", GetParam()}}));
  const auto done = run(controller->home());
  EXPECT_TRUE(done) << done.error().message;
  EXPECT_TRUE(peer.finished());
}
INSTANTIATE_TEST_SUITE_P(Commands, Homing, testing::Values("FRF", "INI"));

TEST_F(GcsLoop, GivesHomingUpWhenNothingMoves) {
  Script script = operator_plus(no_error_before(), {expect("SVO X 1\nERR?\n"), send("0\n"),
                                                    expect("FRF X\nERR?\n"), send("0\n")});
  for (int i = 0; i < 40; ++i)
    script = operator_plus(
        script, operator_plus({expect("FRF?\n"), send("X=0\n")}, state_and_why("X=0\n", "X=1\n")));
  peer.on_connection(set_up_and(script));
  make(axis({{"home_stall_s", "0.1"}}));
  const auto done = run(controller->home());
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().reason, "HOMING_STALLED");
  controller->close();
}

TEST_F(GcsLoop, GivesHomingUpWhenOnlyTheNoiseOfTheScaleMoves) {
  constexpr int kLooks = 40;  // of 5 ms and more, twice the time
  Script script = operator_plus(no_error_before(), {expect("SVO X 1\nERR?\n"), send("0\n"),
                                                    expect("FRF X\nERR?\n"), send("0\n")});
  std::minstd_rand random(7);
  std::normal_distribution<double> noise_nm(0, 60);
  for (int i = 0; i < kLooks; ++i) {
    const std::string position = "X=" + std::to_string(1.0 + 1e-6 * noise_nm(random)) + "\n";
    script = operator_plus(script, operator_plus({expect("FRF?\n"), send("X=0\n")},
                                                 state_and_why("X=0\n", position.c_str())));
  }
  peer.on_connection(set_up_and(script));
  make(axis({{"home_stall_s", "0.1"}}));
  const auto done = run(controller->home());
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().reason, "HOMING_STALLED") << done.error().message;
  controller->close();
}

TEST_F(GcsLoop, EndsHomingWithTheReasonOfTheController) {
  peer.on_connection(set_up_and(operator_plus(
      operator_plus(no_error_before(),
                    {expect("SVO X 1\nERR?\n"), send("0\n"), expect("FRF X\nERR?\n"), send("0\n")}),
      operator_plus({expect("FRF?\n"), send("X=0\n")},
                    state_and_why("X=0\n", "X=1\n", "1024\n", "X=0\n")))));
  make(axis());
  const auto done = run(controller->home());
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().reason, "SERVO_OFF");
  EXPECT_THAT(done.error().message, AllOf(HasSubstr("1024"), HasSubstr("FRF")));
}

// Issue of 1 December: a controller on a serial line loses its mains and answers late once.
TEST_F(GcsLoop, SetsAControllerUpAgainThatLostItsServoWhileItDidNotAnswer) {
  peer.on_connection(set_up_and(operator_plus(
      {expect("\x05"), expect("*IDN?\n"), send("(c) PI, C-887, 1, 2.1\n")},
      operator_plus(
          {expect("*IDN?\n"), send("(c) PI, C-887, 1, 2.1\n"), expect("ERR?\n"), send("0\n"),
           expect("SVO?\n"), send("X=0\n"), expect("SAI?\n"), send("X\n"), expect("TMN?\n"),
           send("X=-3\n"), expect("TMX?\n"), send("X=3\n"), expect("FRF?\n"), send("X=0\n")},
          state_and_why("X=0\n", "X=0\n", "0\n", "X=0\n")))));
  make(axis());
  ASSERT_TRUE(run(controller->prepare()));
  EXPECT_EQ(run(controller->state()).error().reason, "TIMEOUT");
  const auto after = run(controller->state());
  ASSERT_TRUE(after) << after.error().message;
  EXPECT_FALSE(after->referenced);
  EXPECT_FALSE(after->servo_on) << "and stays off until a person homes";
  EXPECT_EQ(controller->health().reconnects, 0);
  EXPECT_TRUE(peer.finished());
}

TEST_F(GcsLoop, StopsDuringAPendingCallAndGoesOnAfterwards) {
  peer.on_connection(
      set_up_and(operator_plus({expect("\x05"), expect("\x18"), expect("*IDN?\n"), send("1\n"),
                                send("(c) PI, C-887, 1, 2.1\n"), expect("ERR?\n"), send("10\n"),
                                expect("ERR?\n"), send("0\n")},
                               state_and_why("X=0\n", "X=0.7\n"))));
  make(axis());
  ASSERT_TRUE(run(controller->prepare()));
  std::optional<Result<void>> stopped;
  asio::steady_timer later(context, 20ms);
  later.async_wait([&](auto) {
    asio::co_spawn(context, controller->stop(),
                   [&](std::exception_ptr, Result<void> r) { stopped = r; });
  });
  const auto before = std::chrono::steady_clock::now();
  const auto interrupted = run(controller->state());
  EXPECT_LT(std::chrono::steady_clock::now() - before, 200ms) << "at once, not at the time-out";
  ASSERT_FALSE(interrupted);
  EXPECT_EQ(interrupted.error().code, ErrorCode::aborted);
  const auto after = run(controller->state());
  ASSERT_TRUE(after) << after.error().message;
  EXPECT_THAT(after->q_mm, ElementsAre(0.7));
  ASSERT_TRUE(stopped);
  EXPECT_TRUE(*stopped);
}

TEST_F(GcsLoop, AbortsACallThatWaitedWhenTheStopCame) {
  peer.on_connection(set_up_and({expect("\x05"), expect("\x18"), expect("*IDN?\n"),
                                 send("(c) PI, C-887, 1, 2.1\n"), expect("ERR?\n"), send("0\n")}));
  make(axis());
  ASSERT_TRUE(run(controller->prepare()));
  std::optional<Result<MotionState>> pending;
  std::optional<Result<void>> queued, stopped;
  static const std::vector<double> kTarget{1.0};
  asio::co_spawn(context, controller->state(),
                 [&](std::exception_ptr, Result<MotionState> r) { pending = r; });
  asio::co_spawn(context, controller->start_move(kTarget),
                 [&](std::exception_ptr, Result<void> r) { queued = r; });
  let_pass(20ms);
  EXPECT_TRUE(run(controller->stop()));
  let_pass(20ms);
  ASSERT_TRUE(pending && queued);
  EXPECT_EQ(pending->error().code, ErrorCode::aborted);
  EXPECT_EQ(queued->error().code, ErrorCode::aborted) << "no move may start after a stop";
}

TEST_F(GcsLoop, ASecondStopDoesNotMakeTheFirstFail) {
  peer.on_connection(set_up_and({expect("\x18"), expect("*IDN?\n"), expect("\x18"),
                                 send("(c) PI, C-887, 1, 2.1\n"), expect("ERR?\n"), send("10\n"),
                                 expect("ERR?\n"), send("0\n"), expect("ERR?\n"), send("0\n")}));
  make(axis());
  ASSERT_TRUE(run(controller->prepare()));
  std::optional<Result<void>> first;
  asio::co_spawn(context, controller->stop(),
                 [&](std::exception_ptr, Result<void> r) { first = r; });
  let_pass(20ms);
  EXPECT_TRUE(run(controller->stop()));
  let_pass(20ms);
  ASSERT_TRUE(first);
  EXPECT_TRUE(*first) << first->error().message;
}

TEST_F(GcsLoop, ManyStopsAreSentAtOnceAndShareTheNextTidying) {
  peer.on_connection(
      set_up_and(operator_plus({expect("\x18"), expect("*IDN?\n"), expect(std::string(50, '\x18')),
                                send("(c) PI, C-887, 1, 2.1\n"), expect("ERR?\n"), send("10\n"),
                                expect("ERR?\n"), send("0\n"), expect("ERR?\n"), send("0\n")},
                               state("0\n", "X=1\n", "X=0.5\n"))));
  make(axis());
  ASSERT_TRUE(run(controller->prepare()));
  int good = 0;
  const auto press = [&] {
    asio::co_spawn(context, controller->stop(),
                   [&](std::exception_ptr, Result<void> stopped) { good += stopped ? 1 : 0; });
  };
  press();
  let_pass(20ms);
  for (int i = 0; i < 50; ++i) press();
  let_pass(50ms);
  EXPECT_EQ(good, 51);
  const auto rests = run(controller->state());
  ASSERT_TRUE(rests) << rests.error().message;
  EXPECT_FALSE(rests->moving);
}

TEST_F(GcsLoop, StopsThoughItWasNotConnected) {
  peer.on_connection(operator_plus({expect("\x18")}, set_up_and({})));
  peer.on_connection(set_up_and({}));
  make(axis());
  EXPECT_TRUE(run(controller->stop()));
}

// Issue 11, number 13: the acknowledgement came, the line broke, and the axis may still move.
TEST_F(GcsLoop, StopsFirstOnEveryNewConnectionUntilTwoAnswersReportNoMotion) {
  peer.on_connection(set_up_and({expect("\x18"), expect("*IDN?\n"), send("(c) PI, C-887, 1, 2.1\n"),
                                 expect("ERR?\n"), send("10\n"), expect("ERR?\n"), send("0\n"),
                                 expect("\x05"), hang_up()}));
  peer.on_connection(operator_plus(
      {expect("\x18")}, set_up_and(operator_plus(state("1\n", "X=0\n", "X=0.5\n"),
                                                 operator_plus(state_and_why("X=0\n", "X=0.6\n"),
                                                               {expect("\x05"), hang_up()})))));
  peer.on_connection(operator_plus(
      {expect("\x18")}, set_up_and(operator_plus(state_and_why("X=0\n", "X=0.6\n"),
                                                 operator_plus(state_and_why("X=0\n", "X=0.6\n"),
                                                               {expect("\x05"), hang_up()})))));
  peer.on_connection(set_up_and(state_and_why("X=0\n", "X=0.6\n")));
  make(axis());
  ASSERT_TRUE(run(controller->prepare()));
  ASSERT_TRUE(run(controller->stop()));
  EXPECT_FALSE(run(controller->state()));
  EXPECT_TRUE(run(controller->state())->moving) << "stopped again, and still on its way";
  EXPECT_FALSE(run(controller->state())->moving);
  EXPECT_FALSE(run(controller->state()));  // one answer of no motion is not two
  EXPECT_FALSE(run(controller->state())->moving);
  EXPECT_FALSE(run(controller->state())->moving);
  EXPECT_FALSE(run(controller->state()));
  EXPECT_TRUE(run(controller->state())) << "confirmed: a new connection begins as usual";
  EXPECT_TRUE(peer.finished());
}

TEST_F(GcsLoop, SetsTheDeviceUpAgainAfterTheLineBroke) {
  peer.on_connection(set_up_and({expect("\x05"), hang_up()}));
  peer.on_connection(set_up_and(state_and_why("X=0\n", "X=0\n"), "X=0\n"));
  make(axis());
  EXPECT_EQ(run(controller->state()).error().reason, "LINK_LOST");
  const auto again = run(controller->state());
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_FALSE(again->referenced) << "the controller was switched off meanwhile";
  EXPECT_EQ(controller->health().reconnects, 1);
}

TEST_F(GcsLoop, ComesBackInStepAfterNonsense) {
  peer.on_connection(set_up_and(operator_plus(
      {expect("\x05"), send("what?\n"), expect("*IDN?\n"), send("(c) PI, C-887, 1, 2.1\n")},
      state("0\n", "X=1\n", "X=0\n"))));
  make(axis());
  const auto nonsense = run(controller->state());
  ASSERT_FALSE(nonsense);
  EXPECT_EQ(nonsense.error().code, ErrorCode::data_loss);
  EXPECT_THAT(nonsense.error().message,
              AllOf(HasSubstr("what?"), HasSubstr("hexadecimal"), HasSubstr("\\x05")));
  EXPECT_TRUE(run(controller->state()));
}

TEST(GcsFactory, ChecksOptionsAndAddress) {
  asio::io_context context;
  tests::WallClock clock;
  DeviceDescription device;
  device.id = "axis";
  device.address = "127.0.0.1:5000";
  EXPECT_EQ(drivers::make_pi_gcs(device, context.get_executor(), clock).error().reason, "NO_AXES");
  device.become<MotionSettings>().axes.push_back({{"q1", "mm"}, "X", -1, 1, 0});
  EXPECT_TRUE(drivers::make_pi_gcs(device, context.get_executor(), clock));
  device.options["velocity"] = "1";
  EXPECT_EQ(drivers::make_pi_gcs(device, context.get_executor(), clock).error().reason,
            "BAD_OPTION");
  device.options.clear();
  device.address = "somewhere";
  EXPECT_EQ(drivers::make_pi_gcs(device, context.get_executor(), clock).error().reason,
            "BAD_ADDRESS");
}

}  // namespace
}  // namespace driftwise
