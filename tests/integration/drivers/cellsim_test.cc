// Each driver against the simulated cell, with the switches of what the protocols leave open in
// both positions.

#include <cmath>
#include <cstdio>

#include "drivers/interferometer_adapter/interferometer_adapter.h"
#include "drivers/keithley_2701/keithley_2701.h"
#include "drivers/pi_gcs/pi_gcs.h"
#include "drivers/watlow_ez_zone/watlow_ez_zone.h"
#include "server/core/try.h"
#include "tests/integration/drivers/simulated_cell.h"

namespace driftwise {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using Settings = std::vector<std::string>;
using Options = std::map<std::string, std::string>;

class AgainstCellsim : public testing::Test {
 protected:
  void SetUp() override {
    if (!tests::SimulatedCell::available())
      GTEST_SKIP() << "NOT TESTED: build driftwise-cellsim first";
  }
  void start(const Settings& settings = {}, double speed = 200) {
    cell = std::make_unique<tests::SimulatedCell>(settings, speed);
  }
  template <class T>
  T run(Awaitable<T> work) {
    return tests::run(context, std::move(work), 30s);
  }
  DeviceDescription described(const std::string& id, const Options& options) {
    auto out = cell->device(id);
    for (const auto& [name, value] : options) out.options[name] = value;
    return out;
  }
  template <class Made>
  auto take(Made made) {
    EXPECT_TRUE(made) << made.error().message;
    return std::move(*made);
  }
  std::unique_ptr<MotionController> axis(const Options& options = {}) {
    return take(
        drivers::make_pi_gcs(described("axis", options), context.get_executor(), cell->clock()));
  }
  std::unique_ptr<Instrument> scanner(const Options& options = {},
                                      const std::string& address = {}) {
    auto description = described("scanner", options);
    if (!address.empty()) description.address = address;
    return take(drivers::make_keithley_2701(description, context.get_executor(), cell->clock()));
  }
  std::unique_ptr<Instrument> laser(const Options& options = {}) {
    return take(drivers::make_interferometer_adapter(described("laser-x", options),
                                                     context.get_executor(), cell->clock()));
  }
  std::unique_ptr<Stabiliser> support(const Options& options = {},
                                      const std::string& address = {}) {
    auto description = described("support", options);
    if (!address.empty()) description.address = address;
    return take(drivers::make_watlow_ez_zone(description, context.get_executor(), cell->clock()));
  }
  // Polls as the engine does; the state at the end of the move.
  Awaitable<Result<MotionState>> move_and_wait(MotionController& controller, double q_mm) {
    const std::vector<double> target{q_mm};
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await controller.start_move(target));
    for (;;) {
      const auto state = co_await controller.state();
      if (!state) co_return state;
      if (!state->moving && state->on_target) co_return state;
      co_await cell->clock().sleep_for(50ms);
    }
  }

  std::unique_ptr<tests::SimulatedCell> cell;
  asio::io_context context{1};
};

struct AxisCase {
  const char* name;
  Settings settings;
  Options options;
};
class AxisAgainstCellsim : public AgainstCellsim, public testing::WithParamInterface<AxisCase> {};

TEST_P(AxisAgainstCellsim, HomesMovesAndStops) {
  // Slow enough that a busy machine still catches the last move under way: it takes 3.5 s, 175 ms
  // of wall.
  start(GetParam().settings, 20);
  auto options = GetParam().options;
  options["velocity_mm_s"] = "1";
  const auto controller = axis(options);
  const auto ready = run(controller->prepare());
  ASSERT_TRUE(ready) << ready.error().message;
  const std::vector<double> early{0.1};
  const auto refused = run(controller->start_move(early));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "NOT_REFERENCED");
  const auto homed = run(controller->home());
  ASSERT_TRUE(homed) << homed.error().message;
  EXPECT_TRUE(run(controller->state())->referenced);
  for (const double q_mm : {1.0, 1.0, -0.5}) {
    const auto there = run(move_and_wait(*controller, q_mm));
    ASSERT_TRUE(there) << there.error().message;
    EXPECT_NEAR(there->q_mm[0], q_mm, 300e-6) << "at the end of the move, not at its beginning";
  }
  const std::vector<double> far{-4.0};
  ASSERT_TRUE(run(controller->start_move(far)));
  run([](Clock& clock) -> Awaitable<int> {
    co_await clock.sleep_for(400ms);
    co_return 0;
  }(cell->clock()));
  const auto stopped = run(controller->stop());
  ASSERT_TRUE(stopped) << stopped.error().message;
  const auto rest = run(controller->state());
  ASSERT_TRUE(rest) << rest.error().message;
  EXPECT_GT(rest->q_mm[0], -4.0 + 0.01);
  EXPECT_TRUE(run(move_and_wait(*controller, 0.0))) << "a stop leaves nothing behind";
}

INSTANTIATE_TEST_SUITE_P(
    Switches, AxisAgainstCellsim,
    testing::Values(
        AxisCase{"as_delivered", {}, {}}, AxisCase{"pipelined", {}, {{"pipelining", "on"}}},
        AxisCase{"ini", {}, {{"reference", "INI"}}},
        AxisCase{"status_word", {}, {{"referenced_by", "status"}}},
        AxisCase{"status_word_without_prefix",
                 {"emulator.pi.status_prefix="},
                 {{"referenced_by", "status"}}},
        AxisCase{"referenced_from_memory", {}, {{"referenced_by", "memory"}}},
        AxisCase{"moving_before_start", {"emulator.pi.moving_before_start=true"}, {}},
        AxisCase{"on_target_drops_at_once", {"emulator.pi.stale_on_target=false"}, {}},
        AxisCase{"no_travel_query", {"emulator.pi.limits=false"}, {{"travel_query", "off"}}},
        AxisCase{"first_error_kept", {"emulator.pi.error_keep=first"}, {}},
        AxisCase{"velocity_per_axis", {"emulator.pi.vls=false"}, {{"velocity_command", "VEL"}}},
        AxisCase{"replies_whole", {"wire.chop=false"}, {{"pipelining", "on"}}}),
    [](const auto& row) { return std::string(row.param.name); });

TEST_F(AgainstCellsim, AxisSaysWhichOptionIsWrongForThisController) {
  start({"emulator.pi.ini=false", "emulator.pi.limits=false"});
  const auto no_limits = run(axis()->prepare());
  ASSERT_FALSE(no_limits);
  EXPECT_THAT(no_limits.error().message, HasSubstr("travel_query"));
  const auto no_ini = run(axis({{"travel_query", "off"}, {"reference", "INI"}})->home());
  ASSERT_FALSE(no_ini);
  EXPECT_EQ(no_ini.error().reason, "UNKNOWN_COMMAND");
}

struct ScannerCase {
  const char* name;
  Settings settings;
  Options options;
  bool serial = false;
};
class ScannerAgainstCellsim : public AgainstCellsim,
                              public testing::WithParamInterface<ScannerCase> {};

TEST_P(ScannerAgainstCellsim, ReadsTenThermometersOfARoom) {
  start(GetParam().settings);
  const auto instrument =
      scanner(GetParam().options, GetParam().serial ? cell->address("scanner-serial") : "");
  for (int i = 0; i < 2; ++i) {
    const CellTime asked = cell->clock().now().utc;
    const auto reading = run(instrument->read());
    ASSERT_TRUE(reading) << reading.error().message;
    ASSERT_EQ(reading->values.size(), 10u);
    for (const auto& value : reading->values) EXPECT_NEAR(value.value, 21.0, 3.0) << value.channel;
    EXPECT_GE(reading->end, asked);
    EXPECT_LE(reading->end, cell->clock().now().utc);
    EXPECT_NEAR(seconds_from(reading->end - reading->start), 4.3, 1.0)
        << "ten compensated readings of 5 NPLC";
  }
  EXPECT_THAT(instrument->health().identity, HasSubstr("MODEL 27"));
}

INSTANTIATE_TEST_SUITE_P(
    Switches, ScannerAgainstCellsim,
    testing::Values(
        ScannerCase{"as_delivered", {}, {}}, ScannerCase{"crlf", {}, {{"terminator", "crlf"}}},
        ScannerCase{"forty_channel_card", {"emulator.scanner.slot1=7708"}, {}},
        ScannerCase{"scan_in_typed_order", {"emulator.scanner.scan_order=typed"}, {}},
        ScannerCase{
            "parameters_before_function", {"emulator.scanner.parameter_needs_function=false"}, {}},
        ScannerCase{"serial_cr", {"emulator.scanner.serial=true"}, {{"baud", "19200"}}, true},
        ScannerCase{"serial_lfcr",
                    {"emulator.scanner.serial=true", "emulator.scanner.serial_terminator=\\n\\r"},
                    {{"baud", "19200"}},
                    true}),
    [](const auto& row) { return std::string(row.param.name); });

TEST_F(AgainstCellsim, ScannerSaysThatThereIsNoCard) {
  start({"emulator.scanner.slot1=NONE"});
  EXPECT_EQ(run(scanner()->prepare()).error().reason, "NO_CARD");
}

TEST_F(AgainstCellsim, LaserIsZeroedAndReadsNanometresAboutIt) {
  start();
  const auto instrument = laser();
  ASSERT_TRUE(run(instrument->zero()));
  const auto reading = run(instrument->read());
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_LT(std::abs(*reading->find("x_mm")), 2e-3);
  EXPECT_GT(*reading->find("x_std_nm"), 0.0);
  EXPECT_NEAR(*reading->find("air_degC"), 21.0, 3.0);
  EXPECT_NEAR(seconds_from(reading->end - reading->start), 0.5, 0.3) << "2048 samples";
}

struct SupportCase {
  const char* name;
  Settings settings;
  Options options;
  bool serial = false;
};
class SupportAgainstCellsim : public AgainstCellsim,
                              public testing::WithParamInterface<SupportCase> {};

TEST_P(SupportAgainstCellsim, TakesASetPointAndReportsIt) {
  start(GetParam().settings);
  const auto stabiliser =
      support(GetParam().options, GetParam().serial ? cell->address("support-serial") : "");
  const auto before = run(stabiliser->read());
  ASSERT_TRUE(before) << before.error().message;
  EXPECT_NEAR(*before->find("support_degC"), 21.0, 3.0);
  const auto set = run(stabiliser->set_point(22.125));
  ASSERT_TRUE(set) << set.error().message;
  const auto after = run(stabiliser->read());
  ASSERT_TRUE(after) << after.error().message;
  EXPECT_NEAR(*after->find("support_set_degC"), 22.125, 1e-5);
}

INSTANTIATE_TEST_SUITE_P(
    Switches, SupportAgainstCellsim,
    testing::Values(SupportCase{"as_delivered", {}, {}},
                    SupportCase{"high_word_first",
                                {"emulator.watlow.low_word_first=false"},
                                {{"word_order", "high_first"}}},
                    SupportCase{"celsius", {"emulator.watlow.fahrenheit=false"}, {{"unit", "C"}}},
                    SupportCase{"rtu", {"emulator.watlow.rtu=true"}, {}, true}),
    [](const auto& row) { return std::string(row.param.name); });

TEST_F(AgainstCellsim, SupportIsNotHeatedOnAWrongUnitOrWordOrder) {
  start();
  EXPECT_EQ(run(support({{"unit", "C"}})->prepare()).error().reason, "UNIT_MISMATCH");
  EXPECT_EQ(run(support({{"word_order", "high_first"}})->set_point(21)).error().reason,
            "IMPLAUSIBLE_PV");
}

// Printed, not judged: what a poll costs in wall time beside the emulator's own 2 ms (10 us at 200
// x) latency.
TEST_F(AgainstCellsim, TellsWhatAPollCosts) {
  start({"wire.chop=false"});
  for (const char* pipelining : {"off", "on"}) {
    const auto controller = axis({{"pipelining", pipelining}});
    ASSERT_TRUE(run(controller->prepare()));
    const auto before = std::chrono::steady_clock::now();
    constexpr int kPolls = 500;
    for (int i = 0; i < kPolls; ++i) ASSERT_TRUE(run(controller->state()));
    const std::chrono::duration<double, std::micro> took =
        std::chrono::steady_clock::now() - before;
    std::printf("state(), pipelining %s: %.0f us\n", pipelining, took.count() / kPolls);
  }
}

}  // namespace
}  // namespace driftwise
