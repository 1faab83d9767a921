#include "drivers/simulated/emulators/interferometer_adapter/interferometer_emulator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/emulators/conversation.h"
#include "tests/unit/emulators/test_plant.h"

namespace driftwise::simulated {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

struct Adapter {
  explicit Adapter(Settings settings = {})
      : emulator(plant, switches_with(InterferometerEmulator::switches(), settings), 0),
        line(emulator) {}
  TestPlant plant;
  InterferometerEmulator emulator;
  Conversation line;
};

TEST(InterferometerAdapter, SaysWhatItIs) {
  EXPECT_EQ(Adapter().line.ask("IDN?\n"), "OK SIOS SP-2000 SP2000-0471 ch=1\n");
  EXPECT_EQ(Adapter({{"channels", "2"}}).line.ask("idn?\r\n"),
            "OK SIOS SP-2000 SP2000-0471 ch=2\n");
}

TEST(InterferometerAdapter, MeasuresForAsLongAsItsSamplesTake) {
  Adapter adapter;
  adapter.line.say("MEAS? 1\n");
  EXPECT_EQ(adapter.line.hear(0.999), "");
  EXPECT_EQ(adapter.line.hear(0.1),
            "OK ch=1 n=4096 mean_nm=1234.5678 std_nm=3.5000 t_air_C=20.25000 t_age_s=1.500 "
            "level_pct=85.0 "
            "status=0x0010 t0=1700000000.000000000 t1=1700000001.000000000\n");
  EXPECT_EQ(adapter.line.ask("AVG 2048\n"), "OK\n");
  adapter.line.say("MEAS? 1\n");
  EXPECT_THAT(adapter.line.hear(0.502), HasSubstr("n=2048"));
}

TEST(InterferometerAdapter, AnswersOneAfterTheOther) {
  Adapter adapter;
  adapter.line.say("MEAS? 1\nIDN?\nMEAS? 1\n");
  EXPECT_EQ(adapter.line.hear(0.9), "");
  EXPECT_THAT(adapter.line.hear(0.2), HasSubstr("\nOK SIOS"));
  EXPECT_THAT(adapter.line.hear(1.0), StartsWith("OK ch=1"));
}

TEST(InterferometerAdapter, ZeroesTheChannelsOfItsMask) {
  Adapter adapter({{"channels", "2"}});
  EXPECT_EQ(adapter.line.ask("ZERO 2\n"), "OK\n");
  EXPECT_EQ(adapter.plant.zeroed, 2);
  EXPECT_EQ(adapter.line.ask("ZERO 7\n"), "OK\n") << "bits without a channel are ignored";
  EXPECT_EQ(adapter.plant.zeroed, 3);
}

TEST(InterferometerAdapter, TakesTheDeadPath) {
  Adapter adapter;
  EXPECT_EQ(adapter.line.ask("DEADPATH 1 120.5\n"), "OK\n");
  EXPECT_EQ(adapter.plant.dead_path_mm, 120.5);
}

TEST(InterferometerAdapter, ABrokenBeamIsAnErrorUntilZeroed) {
  Adapter adapter;
  adapter.plant.beam_broken = true;
  EXPECT_THAT(adapter.line.ask("MEAS? 1\n", 2), StartsWith("ERR 3 "));
  EXPECT_THAT(adapter.line.ask("MEAS? 1\n", 2), StartsWith("ERR 3 "));
  EXPECT_EQ(adapter.line.ask("ZERO 1\n"), "OK\n");
  EXPECT_THAT(adapter.line.ask("MEAS? 1\n", 2), StartsWith("OK ch=1"));
}

TEST(InterferometerAdapter, AnUnstableLaserIsAnErrorOrAStatus) {
  Adapter strict, lax({{"unstable_is_error", "false"}});
  strict.plant.laser_stable = lax.plant.laser_stable = false;
  EXPECT_THAT(strict.line.ask("MEAS? 1\n", 2), StartsWith("ERR 6 "));
  EXPECT_THAT(lax.line.ask("MEAS? 1\n", 2), HasSubstr("status=0x0020"));
}

struct AdapterRefusal {
  const char *name, *line, *begins;
};
class AdapterRefuses : public testing::TestWithParam<AdapterRefusal> {};
TEST_P(AdapterRefuses, WithACode) {
  Adapter adapter;
  EXPECT_THAT(adapter.line.ask(std::string(GetParam().line) + "\n", 2),
              StartsWith(GetParam().begins));
}
INSTANTIATE_TEST_SUITE_P(
    Table, AdapterRefuses,
    testing::Values(AdapterRefusal{"Unknown", "HELLO", "ERR 1 "},
                    AdapterRefusal{"NoChannel", "MEAS?", "ERR 1 "},
                    AdapterRefusal{"OtherChannel", "MEAS? 2", "ERR 2 "},
                    AdapterRefusal{"ChannelNoNumber", "MEAS? x", "ERR 1 "},
                    AdapterRefusal{"OddAverage", "AVG 4095", "ERR 1 "},
                    AdapterRefusal{"EmptyMask", "ZERO 0", "ERR 1 "},
                    AdapterRefusal{"NegativeDeadPath", "DEADPATH 1 -3", "ERR 1 "},
                    AdapterRefusal{"DeadPathElsewhere", "DEADPATH 3 3", "ERR 2 "},
                    AdapterRefusal{"TooMuch", "IDN? please", "ERR 1 "}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(InterferometerAdapter, ATooLongLineIsOneError) {
  Adapter adapter;
  EXPECT_THAT(adapter.line.ask(std::string(100000, 'A') + "\nIDN?\n", 2),
              testing::MatchesRegex("ERR 5 [^\n]*\nOK [^\n]*\n"));
}

TEST(InterferometerAdapter, NeedsAsManyInterferometersAsChannels) {
  EXPECT_THROW(Adapter({{"channels", "3"}}), SetupError);
  EXPECT_THROW(Adapter({{"samples", "3000"}}), SetupError);
}

}  // namespace
}  // namespace driftwise::simulated
