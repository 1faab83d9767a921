#include "drivers/simulated/emulators/pi_gcs/pi_gcs_emulator.h"

#include <gtest/gtest.h>

#include "tests/unit/emulators/conversation.h"
#include "tests/unit/emulators/test_plant.h"

namespace driftwise::simulated {
namespace {

struct Controller {
  explicit Controller(Settings settings = {}, int axes = 1)
      : plant(axes),
        emulator(plant, 0, switches_with(PiGcsEmulator::switches(), settings), kStart),
        line(emulator) {}
  void home() {
    line.ask("SVO X 1\nFRF X\n", 4);
    ASSERT_EQ(line.ask("ERR?\n"), "0\n");
  }
  std::string error_after(std::string_view command) {
    return line.ask(std::string(command) + "\nERR?\n", 0.1);
  }

  TestPlant plant;
  PiGcsEmulator emulator;
  Conversation line;
};

TEST(PiGcs, IdentifiesAndNamesItsAxes) {
  Controller pi;
  EXPECT_TRUE(pi.line.ask("*IDN?\n").find("Physik Instrumente") != std::string::npos);
  EXPECT_EQ(pi.line.ask("SAI?\n"), "X\n");
}

TEST(PiGcs, PutsABlankBeforeEveryLineFeedButTheLast) {
  Controller pi({{"axes", "X,Y,Z"}}, 3);
  EXPECT_EQ(pi.line.ask("POS?\n"), "X=0.0000000 \nY=0.0000000 \nZ=0.0000000\n");
  EXPECT_EQ(pi.line.ask("POS? Z X\n"), "Z=0.0000000 \nX=0.0000000\n");
  EXPECT_EQ(pi.line.ask("SAI?\n"), "X \nY \nZ\n");
}

TEST(PiGcs, SettersAreSilent) {
  Controller pi;
  EXPECT_EQ(pi.line.ask("SVO X 1\nFRF X\nVLS 2\n", 5), "");
}

TEST(PiGcs, ReferencingTakesItsTimeAndShowsInEveryStatus) {
  Controller pi;
  pi.line.say("SVO X 1\nFRF X\n");
  EXPECT_EQ(pi.line.ask("FRF?\n", 0.1), "X=0\n");
  EXPECT_EQ(pi.line.ask("\x05", 0.1), "1\n");
  EXPECT_EQ(pi.line.ask("\x07", 0.1), "\xB0\n");
  EXPECT_EQ(pi.line.ask("\x04", 0.1), "0x0\n");
  pi.line.hear(4);
  EXPECT_EQ(pi.line.ask("FRF?\n", 0.1), "X=1\n");
  EXPECT_EQ(pi.line.ask("\x05", 0.1), "0\n");
  EXPECT_EQ(pi.line.ask("\x07", 0.1), "\xB1\n");
  EXPECT_EQ(pi.line.ask("\x04", 0.1), "0x10000\n");
}

TEST(PiGcs, MotionStartsADelayAfterMov) {
  Controller pi;
  pi.home();
  pi.line.say("MOV X 2\n");
  pi.line.hear(0.15);
  EXPECT_EQ(pi.line.ask("\x05", 0.02), "0\n") << "not moving yet is not the end";
  EXPECT_EQ(pi.line.ask("ONT?\n", 0.02), "X=1\n") << "still answers for the old target";
  EXPECT_EQ(pi.line.ask("MOV?\n", 0.0), "") << "replies take the controller's latency";
  EXPECT_EQ(pi.line.hear(0.02), "X=2.0000000\n");
  pi.line.hear(0.2);
  EXPECT_EQ(pi.line.ask("\x05", 0.02), "1\n");
  EXPECT_EQ(pi.line.ask("ONT?\n", 0.02), "X=0\n");
  pi.line.hear(3);
  EXPECT_EQ(pi.line.ask("POS?\n\x05ONT?\n", 0.1), "X=2.0000000\n0\nX=1\n");
}

TEST(PiGcs, OnTargetFallsAtOnceWhenTheSwitchSaysSo) {
  Controller pi({{"stale_on_target", "false"}, {"moving_before_start", "true"}});
  pi.home();
  pi.line.say("MOV X 2\n");
  EXPECT_EQ(pi.line.ask("ONT?\n", 0.05), "X=0\n");
  EXPECT_EQ(pi.line.ask("\x05", 0.05), "1\n");
}

TEST(PiGcs, SingleBytesOvertakeAHalfTypedLine) {
  Controller pi;
  pi.line.say("PO");
  EXPECT_EQ(pi.line.ask("\x05", 0.1), "0\n");
  EXPECT_EQ(pi.line.ask("S?\n", 0.1), "X=0.0000000\n");
}

TEST(PiGcs, PositionsWhileMovingLookLikePos) {
  Controller pi;
  pi.home();
  pi.line.ask("MOV X 2\n", 1.2);
  const std::string moving = pi.line.ask("\x03", 0.1);
  EXPECT_EQ(moving, "X=1.0000000\n");
}

TEST(PiGcs, StopAllEndsTheMoveAndLeavesError10) {
  Controller pi;
  pi.home();
  pi.line.ask("MOV X 4\n", 1.2);
  pi.line.say("\x18");
  EXPECT_EQ(pi.line.ask("ERR?\nERR?\n", 0.1), "10\n0\n");
  EXPECT_EQ(pi.line.ask("POS?\n", 0.1), "X=1.0000000\n");
  pi.line.hear(5);
  EXPECT_EQ(pi.line.ask("MOV?\n", 0.1), "X=1.0000000\n");
}

TEST(PiGcs, AStopBeforeTheMotionBeganPreventsIt) {
  Controller pi;
  pi.home();
  pi.line.ask("MOV X 4\n", 0.1);
  pi.line.say("\x18");
  pi.line.hear(10);
  EXPECT_EQ(pi.line.ask("POS?\n", 0.1), "X=0.0000000\n");
}

TEST(PiGcs, RelativeMovesAddToTheTarget) {
  Controller pi;
  pi.home();
  pi.line.ask("MOV X 1\nMVR X -0.25\n", 5);
  EXPECT_EQ(pi.line.ask("POS?\n", 0.1), "X=0.7500000\n");
}

struct GcsRefusal {
  const char *name, *command, *error;
  bool homed;
};
class PiGcsRefuses : public testing::TestWithParam<GcsRefusal> {};
TEST_P(PiGcsRefuses, WithItsErrorNumber) {
  Controller pi;
  if (GetParam().homed) pi.home();
  EXPECT_EQ(pi.error_after(GetParam().command), std::string(GetParam().error) + "\n");
  EXPECT_EQ(pi.line.ask("ERR?\n", 0.1), "0\n") << "reading clears it";
  EXPECT_EQ(pi.line.ask("POS?\n", 5).substr(0, 4), "X=0.") << "nothing moved";
}
INSTANTIATE_TEST_SUITE_P(Table, PiGcsRefuses,
                         testing::Values(GcsRefusal{"UnknownCommand", "FOO X 1", "2", true},
                                         GcsRefusal{"UnknownQuery", "FOO?", "2", true},
                                         GcsRefusal{"NoServo", "FRF X", "5", false},
                                         GcsRefusal{"NotReferenced", "MOV X 1", "5", false},
                                         GcsRefusal{"BeyondTravel", "MOV X 5.0001", "7", true},
                                         GcsRefusal{"RelativeBeyondTravel", "MVR X -6", "7", true},
                                         GcsRefusal{"TooFast", "VLS 1000", "8", true},
                                         GcsRefusal{"NoVelocity", "VEL X 0", "8", true},
                                         GcsRefusal{"UnknownAxis", "MOV Q 1", "15", true},
                                         GcsRefusal{"UnknownAxisAsked", "POS? Q", "15", true},
                                         GcsRefusal{"ServoHalfOn", "SVO X 2", "17", true},
                                         GcsRefusal{"TooMany", "MOV X 1 X 2", "24", true},
                                         GcsRefusal{"StopWithArgument", "STP X", "24", true},
                                         GcsRefusal{"NoValue", "MOV X", "26", true},
                                         GcsRefusal{"Nothing", "MOV", "26", true},
                                         GcsRefusal{"NoNumber", "MOV X 1,5", "1", true},
                                         GcsRefusal{"NotFinite", "MOV X nan", "1", true},
                                         GcsRefusal{"Garbage", "!!", "1", true}),
                         [](const auto& row) { return std::string(row.param.name); });

TEST(PiGcs, AQueryThatFailsGivesNoLine) {
  Controller pi;
  EXPECT_EQ(pi.line.ask("FOO?\n", 5), "");
  EXPECT_EQ(pi.line.ask("POS? Q\n", 5), "");
}

TEST(PiGcs, KeepsTheLastErrorOrTheFirst) {
  Controller last;
  EXPECT_EQ(last.error_after("FOO\nMOV Q 1"), "15\n");
  Controller first({{"error_keep", "first"}});
  EXPECT_EQ(first.error_after("FOO\nMOV Q 1"), "2\n");
}

TEST(PiGcs, SwitchesOffWhatAModelLacks) {
  Controller with;
  EXPECT_EQ(with.line.ask("TMN?\nTMX?\n"), "X=-5.0000000\nX=5.0000000\n");
  EXPECT_EQ(with.line.ask("VMO? X 4\nVMO? X 6\n"), "1\n0\n");
  EXPECT_EQ(with.line.ask("SVO X 1\nINI X\nFRF?\n", 4), "X=0\n");
  EXPECT_EQ(with.line.ask("FRF?\n"), "X=1\n");
  EXPECT_EQ(with.line.ask("VLS 2\nVLS?\nVEL?\nERR?\n"), "2.0000000\nX=2.0000000\n0\n");
  Controller without({{"limits", "false"},
                      {"ini", "false"},
                      {"vls", "false"},
                      {"vel", "false"},
                      {"vmo_reply", "axes"}});
  for (const char* command : {"TMN?", "TMX?", "INI X", "VLS 2", "VLS?", "VEL X 2", "VEL?"})
    EXPECT_EQ(without.error_after(command), "2\n") << command;
  EXPECT_EQ(without.line.ask("VMO? X 4\n"), "X=1\n");
}

TEST(PiGcs, ByteRepliesAsConfigured) {
  Controller pi({{"ready_line_feed", "false"}, {"ready_byte", "\\x41"}, {"status_prefix", ""}});
  EXPECT_EQ(pi.line.ask("\x07", 0.1), "A");
  EXPECT_EQ(pi.line.ask("\x04", 0.1), "0\n");
}

TEST(PiGcs, TakesWhatASwitchSays) {
  TestPlant plant;
  EXPECT_THROW(
      PiGcsEmulator(plant, 0, switches_with(PiGcsEmulator::switches(), {{"axes", "X,Y"}}), kStart),
      SetupError);
  EXPECT_THROW(
      PiGcsEmulator(plant, 0, switches_with(PiGcsEmulator::switches(), {{"decimals", "many"}}),
                    kStart),
      SetupError);
  EXPECT_THROW(switches_with(PiGcsEmulator::switches(), {{"no_such", "1"}}), SetupError);
}

}  // namespace
}  // namespace driftwise::simulated
