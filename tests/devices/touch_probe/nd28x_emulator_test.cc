#include "drivers/simulated/emulators/touch_probe/nd28x_emulator.h"

#include <gmock/gmock.h>

#include "tests/unit/emulators/conversation.h"
#include "tests/unit/emulators/test_plant.h"

namespace driftwise::simulated {
namespace {

using testing::StartsWith;

struct Nd28xAtWork {
  explicit Nd28xAtWork(Settings settings = {})
      : emulator(plant, switches_with(Nd28xEmulator::switches(), settings), 0), talk(emulator) {
    plant.length_nm = 1234567.8;
  }
  TestPlant plant;
  Nd28xEmulator emulator;
  Conversation talk;
};

TEST(Nd28xEmulator, AnswersTheByteWithAValueInItsSteps) {
  Nd28xAtWork probe;
  EXPECT_EQ(probe.talk.ask("\x02"), "+  1.234550    \r\n");
  Nd28xAtWork fine({{"step_nm", "5"}});
  EXPECT_EQ(fine.talk.ask("\x02"), "+  1.234570    \r\n");
  Nd28xAtWork elsewhere({{"offset_mm", "-3"}});
  EXPECT_EQ(elsewhere.talk.ask("\x02"), "-  1.765450    \r\n");
}

TEST(Nd28xEmulator, StandsAtItsFreeEndWithoutContact) {
  Nd28xAtWork probe;
  probe.plant.beam_broken = true;
  EXPECT_EQ(probe.talk.ask("\x02"), "-  5.500000    \r\n");
}

TEST(Nd28xEmulator, SaysWhoItIsAndRefusesCommandsThatItDoesNotKnow) {
  Nd28xAtWork probe;
  EXPECT_EQ(probe.talk.ask("\x1b"
                           "A0000\r"),
            "\x02ND 287    \r\n349797-05 \r\nV1.02     \r\n");
  EXPECT_EQ(probe.talk.ask("\x1b"
                           "F9999\r"),
            "\x15");
  EXPECT_EQ(probe.talk.ask("hello\r\n"), "");
  Nd28xAtWork old({{"remote", "false"}});
  EXPECT_EQ(old.talk.ask("\x1b"
                         "A0000\r"),
            "");
  EXPECT_THAT(old.talk.ask("\x02"), StartsWith("+"));
}

TEST(Nd28xEmulator, ShowsInchesOrAMessageWhereASwitchSaysSo) {
  Nd28xAtWork inches({{"inches", "true"}, {"step_nm", "25400"}});
  EXPECT_EQ(inches.talk.ask("\x02"), "+  0.049000 \"  \r\n");
  Nd28xAtWork broken({{"message", "SIGNAL X"}});
  EXPECT_EQ(broken.talk.ask("\x02"), "SIGNAL X\r\n");
}

// Manuals of the ND 281B, page 47, and the ND 287, page 115.
TEST(Nd28xEmulator, SendsARecordOfSeventeenCharactersWithItsMarks) {
  Nd28xAtWork plain;
  EXPECT_EQ(plain.talk.ask("\x02").size(), 17u);
  Nd28xAtWork sorted({{"marks", " =A"}});
  EXPECT_EQ(sorted.talk.ask("\x02"), "+  1.234550  =A\r\n");
  Nd28xAtWork faulty({{"marks", "?"}});
  EXPECT_EQ(faulty.talk.ask("\x02"), "+  1.234550 ?  \r\n");
  TestPlant plant;
  const auto four = switches_with(Nd28xEmulator::switches(), {{"marks", " =A1"}});
  EXPECT_THROW(Nd28xEmulator(plant, four, 0), SetupError);
}

TEST(Nd28xEmulator, NeedsALengthOfThePlant) {
  TestPlant plant;
  const auto switches = switches_with(Nd28xEmulator::switches(), {});
  EXPECT_THROW(Nd28xEmulator(plant, switches, plant.interferometer_count()), SetupError);
}

}  // namespace
}  // namespace driftwise::simulated
