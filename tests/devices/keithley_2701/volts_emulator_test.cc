#include <gmock/gmock.h>

#include "drivers/simulated/emulators/keithley_2701/keithley_emulator.h"
#include "tests/unit/emulators/conversation.h"
#include "tests/unit/emulators/test_plant.h"

namespace driftwise::simulated {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

class PlantWithVolts : public TestPlant {
 public:
  std::map<int, double> volt;
  double input_volt(int input, TimeNs) override { return volt.at(input); }
  bool has_voltage(int input) const override { return volt.contains(input); }
};

struct VoltsAtWork {
  VoltsAtWork() {
    plant.volt[201] = 1.23456789;
    plant.volt[202] = -11;
    for (const char* command :
         {"*RST\n", "INIT:CONT OFF\n", "FORM:ELEM READ,CHAN\n", "FUNC 'VOLT',(@201:203)\n",
          "VOLT:RANG 10,(@201:203)\n", "VOLT:NPLC 1,(@201:203)\n", "SAMP:COUN 3\n",
          "ROUT:SCAN (@201:203)\n", "ROUT:SCAN:LSEL INT\n"})
      talk.ask(command);
  }
  PlantWithVolts plant;
  KeithleyEmulator emulator{plant, switches_with(KeithleyEmulator::switches(), {{"slot2", "7700"}}),
                            kStart};
  Conversation talk{emulator};
};

TEST(KeithleyVolts, AreWhatTheSensorsOfThePlantGiveInStepsOfTheRange) {
  VoltsAtWork scanner;
  const auto scan = scanner.talk.ask("READ?\n", 5);
  EXPECT_THAT(scan, StartsWith("+1.23456800E+00,201,")) << "steps of 1 uV";
  EXPECT_THAT(scanner.talk.ask("SYST:ERR?\n"), HasSubstr("No error"));
}

TEST(KeithleyVolts, OverflowBeyondTheRangeAndAreZeroWhereNothingIsConnected) {
  VoltsAtWork scanner;
  const auto scan = scanner.talk.ask("READ?\n", 5);
  EXPECT_THAT(scan, HasSubstr("+9.9E37,202,"));
  EXPECT_THAT(scan, HasSubstr("+0.00000000E+00,203"));
}

TEST(KeithleyVolts, TakeTwoIntegrationsAndARelayPerInput) {
  VoltsAtWork scanner;
  const auto asked = scanner.talk.now;
  scanner.talk.ask("READ?\n", 5);
  EXPECT_NEAR(seconds_between(asked, scanner.talk.last_sent), 3 * (2 * 0.02 + 0.03), 0.02);
}

}  // namespace
}  // namespace driftwise::simulated
