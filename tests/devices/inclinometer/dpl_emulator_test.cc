#include "drivers/simulated/emulators/inclinometer/dpl_emulator.h"

#include <gmock/gmock.h>

#include "tests/unit/emulators/conversation.h"
#include "tests/unit/emulators/test_plant.h"

namespace driftwise::simulated {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

struct DplAtWork {
  explicit DplAtWork(Settings settings = {})
      : emulator(plant, switches_with(DplEmulator::switches(), settings), 0), talk(emulator) {
    plant.angle.y_arcsec = 1.234 * 3600;
    plant.angle.z_arcsec = -0.007 * 3600;
  }
  TestPlant plant;
  DplEmulator emulator;
  Conversation talk;
};

TEST(DplEmulator, StreamsAfterPowerOnUntilItIsStopped) {
  DplAtWork dpl;
  EXPECT_THAT(dpl.talk.hear(0.35), StartsWith("X=+01.234\r\nY=-00.007\r\nX=+01.234\r\n"));
  EXPECT_THAT(dpl.talk.ask("s"), EndsWith("s"));
  EXPECT_EQ(dpl.talk.hear(), "");
  EXPECT_EQ(dpl.talk.ask("R"), "X=+01.234\r\nY=-00.007\r\n");
  EXPECT_THAT(dpl.talk.ask("S"), HasSubstr("X=+01.234"));
  EXPECT_THAT(dpl.talk.ask("s"), EndsWith("s"));
}

TEST(DplEmulator, AnswersNoPairWhileItStreamsAndNoUnknownByte) {
  DplAtWork dpl({{"stream_period_s", "10"}});
  EXPECT_EQ(dpl.talk.ask("R"), "");
  EXPECT_EQ(dpl.talk.ask("q?\r\n"), "");
  EXPECT_EQ(dpl.talk.ask("V"), "DPL2 V1.8.0\r\nSN:12345678\r\n");
}

TEST(DplEmulator, EchoesWithALineEndWhereTheSwitchSaysSo) {
  DplAtWork dpl({{"streams", "false"}, {"echo_line_end", "true"}});
  EXPECT_EQ(dpl.talk.ask("s"), "s\r\n");
}

TEST(DplEmulator, NeedsAnInstrumentOfThePlant) {
  TestPlant plant;
  const auto switches = switches_with(DplEmulator::switches(), {});
  EXPECT_THROW(DplEmulator(plant, switches, plant.collimator_count()), SetupError);
}

}  // namespace
}  // namespace driftwise::simulated
