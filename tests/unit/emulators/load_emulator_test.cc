#include "drivers/simulated/emulators/load_actuator/load_emulator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "tests/unit/emulators/conversation.h"
#include "tests/unit/emulators/test_plant.h"

namespace driftwise::simulated {
namespace {

using testing::StartsWith;

struct Weights {
  explicit Weights(Settings settings = {})
      : emulator(plant, switches_with(LoadEmulator::switches(), settings)), line(emulator) {}
  TestPlant plant;
  LoadEmulator emulator;
  Conversation line;
};

TEST(LoadActuator, SaysWhatItIsAndWhatHangs) {
  Weights weights;
  EXPECT_EQ(weights.line.ask("IDN?\n"), "OK Driftwise weights 0001\n");
  EXPECT_EQ(weights.line.ask("load?\r\n"), "OK 0 1\n");
}

TEST(LoadActuator, MovesWeightsForAWhile) {
  Weights weights;
  EXPECT_EQ(weights.line.ask("LOAD 2.305\n"), "OK\n");
  EXPECT_EQ(weights.line.ask("LOAD?\n"), "OK 2.305 0\n");
  EXPECT_THAT(weights.line.ask("LOAD 1\n"), StartsWith("ERR 3 "));
  weights.plant.hanging.resting = true;
  EXPECT_EQ(weights.line.ask("LOAD?\n"), "OK 2.305 1\n");
  EXPECT_EQ(weights.line.ask("LOAD 0\n"), "OK\n");
}

TEST(LoadActuator, RefusesWhatItDoesNotHave) {
  Weights weights;
  EXPECT_THAT(weights.line.ask("LOAD 3.9\n"), StartsWith("ERR 2 no such load: 0 to 3.85 N"));
  EXPECT_THAT(weights.line.ask("LOAD -0.1\n"), StartsWith("ERR 2 "));
  EXPECT_THAT(weights.line.ask("LOAD nan\n"), StartsWith("ERR 1 "));
  EXPECT_THAT(weights.line.ask("LOAD\n"), StartsWith("ERR 1 "));
  EXPECT_THAT(weights.line.ask("HELLO 1 2\n"), StartsWith("ERR 1 "));
  EXPECT_EQ(weights.plant.hanging.newton, 0);
}

TEST(LoadActuator, SticksWhenItIsJammed) {
  Weights weights;
  weights.plant.hanging = {1.5, false, true, 3.85};
  EXPECT_THAT(weights.line.ask("LOAD 2\n"), StartsWith("ERR 4 jammed at 1.5 N"));
  EXPECT_EQ(weights.line.ask("LOAD?\n"), "OK 1.5 0\n");
}

TEST(LoadActuator, SurvivesRandomBytes) {
  std::mt19937 random(2);
  const std::string letters = "LOAD? 0123.-+eIDN\r\n";
  Weights weights({{"busy_is_error", "false"}});
  for (int k = 0; k < 20000; ++k) {
    const char c =
        random() % 50 == 0 ? static_cast<char>(random()) : letters[random() % letters.size()];
    weights.line.say(std::string(1, c));
  }
  weights.line.ask("\n");
  EXPECT_EQ(weights.line.ask("IDN?\n"), "OK Driftwise weights 0001\n");
  EXPECT_GE(weights.plant.hanging.newton, 0);
  EXPECT_LE(weights.plant.hanging.newton, 3.85);
}

}  // namespace
}  // namespace driftwise::simulated
