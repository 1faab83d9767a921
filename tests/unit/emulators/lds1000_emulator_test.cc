#include "drivers/simulated/emulators/lds1000/lds1000_emulator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "tests/unit/emulators/conversation.h"
#include "tests/unit/emulators/test_plant.h"

namespace driftwise::simulated {
namespace {

using testing::EndsWith;
using testing::HasSubstr;

struct Collimator {
  explicit Collimator(Settings settings = {}, Link link = Link::tcp)
      : emulator(plant, switches_with(Lds1000Emulator::switches(), settings), 0),
        line(emulator, link) {}
  TestPlant plant;
  Lds1000Emulator emulator;
  Conversation line;
};

TEST(Lds1000, RepeatsTheCommandInItsReply) {
  Collimator c({{"unit", "sec"}});
  EXPECT_EQ(c.line.ask("1TP\r"), "1TP12.34\r\n");  // steps of 0.02
  EXPECT_EQ(c.line.ask("2TP\r"), "2TP-5.00\r\n");
  EXPECT_EQ(c.line.ask("VE\r"), "VE LDS1000 Controller Version 3.10\r\n");
  EXPECT_EQ(c.line.ask("XI\r"), "XI100\r\n");
}

TEST(Lds1000, ComesInMicroradiansUnlessItIsSetUpInSeconds) {
  Collimator delivered;
  EXPECT_EQ(delivered.line.ask("1TA\r"), "1TA,RT,04512,1,\xB5rad,00102,00241\r\n");
  EXPECT_EQ(delivered.line.ask("1TP\r"), "1TP59.8\r\n");  // 12.342 arcsec x 4.8481
  EXPECT_EQ(Collimator({{"micro_byte", "\\xE6"}}).line.ask("2TA\r"),
            "2TA,RT,04498,1,\xE6rad,00102,00241\r\n");
  EXPECT_EQ(Collimator({{"unit", "sec"}}).line.ask("1TA\r"),
            "1TA,RT,04512,0,2,sec,00102,00241\r\n");
  EXPECT_EQ(Collimator({{"unit", "sec"}, {"decimal_comma", "false"}}).line.ask("1TA\r"),
            "1TA,RT,04512,0.2,sec,00102,00241\r\n");
}

TEST(Lds1000, KeepsTheLastErrorUntilItIsRead) {
  Collimator c;
  EXPECT_EQ(c.line.ask("TE\r"), "TE@\r\n");
  EXPECT_EQ(c.line.ask("XX\r3TP\r"), "") << "a wrong command is not answered";
  EXPECT_EQ(c.line.ask("TE\r"), "TEB\r\n") << "only the last one is kept";
  EXPECT_EQ(c.line.ask("TE\r"), "TE@\r\n") << "reading clears it";
  EXPECT_EQ(c.line.ask("tp\r"), "") << "commands are capitals";
  EXPECT_THAT(c.line.ask("TB\r"), testing::StartsWith("TBA Unknown"));
  EXPECT_EQ(c.line.ask("TB\r"), "TB@ No error\r\n");
}

TEST(Lds1000, SettersAreSilent) {
  Collimator c;
  EXPECT_EQ(c.line.ask("KI250\rSP20\rXI\rTE\r"), "XI250\r\nTE@\r\n");
  EXPECT_EQ(c.line.ask("KI0\rTE\r"), "TEC\r\n");
  EXPECT_EQ(c.line.ask("SPfast\rTE\r"), "TEC\r\n");
}

TEST(Lds1000, ShowsALostBeamInItsStatus) {
  Collimator c({{"unit", "sec"}});
  EXPECT_EQ(c.line.ask("MS\r"), "MS@\r\n");
  c.line.ask("1TP\r");
  c.plant.angle.power_wrong = true;
  c.plant.angle.y_arcsec = 300;
  EXPECT_EQ(c.line.ask("MS\r"), "MSA\r\n");
  EXPECT_EQ(c.line.ask("1TP\r"), "1TP12.34\r\n") << "the last good value";
  c.plant.angle.power_wrong = false;
  c.plant.angle.position_wrong = true;
  EXPECT_EQ(c.line.ask("MS\r"), "MSB\r\n");
  Collimator zero({{"lost_reading", "zero"}});
  zero.plant.angle.power_wrong = true;
  EXPECT_EQ(zero.line.ask("1TP\r"), "1TP0.0\r\n");
}

TEST(Lds1000, StoresReadingsAtItsSamplingPeriod) {
  Collimator c({{"unit", "sec"}});
  c.line.say("SP100\rTM5\r");
  EXPECT_EQ(c.line.ask("MS\rXN\r", 0.25), "MSH\r\nXN1\r\n") << "bit 3: acquiring";
  EXPECT_EQ(c.line.ask("TM5\rTE\r", 0.05), "TED\r\n") << "not while it acquires";
  c.line.hear(0.5);
  EXPECT_EQ(c.line.ask("MS\rXN\r"), "MS@\r\nXN5\r\n");
  EXPECT_EQ(c.line.ask("5TT\r"), "5TT,1TP12.34,2TP-5.00\r\n");
  EXPECT_EQ(c.line.ask("6TT\rTE\r"), "TEC\r\n");
  const TimeNs before = c.line.now;
  EXPECT_THAT(c.line.ask("0TT\r"), EndsWith("5TT,1TP12.34,2TP-5.00\r\n"));
  EXPECT_NEAR(seconds_between(before, c.line.last_sent), 0.11, 1e-6);  // 10 ms and four gaps of 25
  EXPECT_EQ(c.line.ask("TM2049\rTE\r"), "TEC\r\n") << "2048 places";
}

TEST(Lds1000, WaitsForATriggerThatNeverComesUntilItIsStopped) {
  Collimator c;
  EXPECT_EQ(c.line.ask("TK3\rMS\r"), "MSL\r\n");  // waiting and acquiring
  EXPECT_EQ(c.line.ask("TQ\rMS\rXN\r"), "MS@\r\nXN0\r\n");
  EXPECT_EQ(Collimator({{"stop", "false"}}).line.ask("TQ\rTE\r"), "TEA\r\n");
}

TEST(Lds1000, TakesAnyMixOfLineEnds) {
  Collimator c({{"terminator", "\\r"}});
  EXPECT_EQ(c.line.ask("TE\n"), "TE@\r");
  EXPECT_EQ(c.line.ask("TE\r\n\n\rTE\n\r"), "TE@\rTE@\r");
  EXPECT_EQ(c.line.ask(std::string(300, '1') + "TP\rTE\r"), "TEA\r") << "255 characters";
}

TEST(Lds1000, TakesTimeOnASerialLine) {
  Collimator c({{"unit", "sec"}}, Link::serial);
  const TimeNs before = c.line.now;
  c.line.ask("1TP\r2TP\r");
  // 10 ms, then 10 + 10 characters of 10 bits at 9600.
  EXPECT_NEAR(seconds_between(before, c.line.last_sent), 0.01 + 20 * 10 / 9600.0, 1e-6);
}

TEST(Lds1000, SurvivesRandomBytes) {
  std::mt19937 random(1);
  const std::string letters = "12TPTAMSTEKIXNTMTQVE\r\n0,.-\xB5";
  Collimator c;
  for (int k = 0; k < 20000; ++k) {
    const std::size_t place = random() % letters.size();
    c.line.say(std::string(1, random() % 50 == 0 ? static_cast<char>(random()) : letters[place]));
    if (k % 100 == 0) c.line.hear(0.1);
  }
  c.line.ask("\r");
  c.line.hear(1000);
  c.line.ask("TQ\rTE\r");
  EXPECT_EQ(c.line.ask("VE\r"), "VE LDS1000 Controller Version 3.10\r\n");
}

TEST(Lds1000, NeedsAnAutocollimatorOfThePlant) {
  TestPlant plant;
  EXPECT_THROW(Lds1000Emulator(plant, switches_with(Lds1000Emulator::switches(), {}), 2),
               SetupError);
}

}  // namespace
}  // namespace driftwise::simulated
