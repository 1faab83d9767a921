#include "drivers/simulated/emulators/keithley_2701/keithley_emulator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/emulators/conversation.h"
#include "tests/unit/emulators/test_plant.h"

namespace driftwise::simulated {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

struct Scanner {
  explicit Scanner(Settings settings = {}, Link link = Link::tcp)
      : emulator(plant, switches_with(KeithleyEmulator::switches(), settings),
                 kStart - 10 * kSecondNs),
        line(emulator, link) {
    line.say("*RST\n*CLS\n");
    line.hear(1);
  }
  std::string ask(const std::string& text, double seconds = 0.5) {
    return line.ask(text + "\n", seconds);
  }
  std::string error_after(const std::string& text) {
    line.ask(text + "\n", 5);
    return ask("SYST:ERR?");
  }
  // The set-up that several public programs use.
  void set_up(int channels = 10) {
    const std::string list = ",(@101:" + std::to_string(100 + channels) + ")";
    for (const std::string& text :
         {std::string("TRAC:CLE"), std::string("INIT:CONT OFF"),
          std::string("FORM:ELEM READ,CHAN,TST"), std::string("TRIG:SOUR IMM"),
          std::string("TRIG:COUN 1"), std::string("TRIG:DEL 0"), "FUNC 'FRES'" + list,
          "FRES:RANG 1000" + list, "FRES:OCOM ON" + list, "FRES:NPLC 5" + list,
          "SAMP:COUN " + std::to_string(channels), "ROUT:SCAN " + list.substr(1),
          std::string("ROUT:SCAN:TSO IMM"), std::string("ROUT:SCAN:LSEL INT")})
      ask(text, 0.001);
    ASSERT_EQ(ask("SYST:ERR?"), "0,\"No error\"\n");
  }
  TestPlant plant;
  KeithleyEmulator emulator;
  Conversation line;
};

TEST(Keithley, IdentifiesItselfAndItsCards) {
  Scanner scanner;
  EXPECT_THAT(scanner.ask("*IDN?"), StartsWith("KEITHLEY INSTRUMENTS INC.,MODEL 2701,"));
  EXPECT_EQ(scanner.ask("*OPT?"), "7700,NONE\n");
  EXPECT_EQ(Scanner({{"slot2", "7708"}}).ask("*OPT?"), "7700,7708\n");
}

TEST(Keithley, ScansTenProbesInFourWireOhms) {
  Scanner scanner;
  scanner.set_up(2);
  scanner.plant.ohm[102] = 1077.935;
  const TimeNs asked = scanner.line.now;
  // The clock of the time stamps started at power-on, 10 s before the first word.
  EXPECT_THAT(scanner.ask("READ?", 10),
              testing::MatchesRegex("\\+1\\.08100000E\\+03,\\+1[0-9]\\.[0-9]{3},101,"
                                    "\\+1\\.07793500E\\+03,\\+1[0-9]\\.[0-9]{3},102\n"));
  // 4 * 5 / 50 Hz and 30 ms of relay per channel, 5 ms to the reply.
  EXPECT_NEAR(seconds_between(asked, scanner.line.last_sent), 2 * 0.43 + 0.005, 1e-9);
}

TEST(Keithley, IntegrationTimeFollowsTheSettings) {
  const auto duration = [](const char* settings) {
    Scanner scanner;
    scanner.set_up(10);
    scanner.ask(settings);
    const TimeNs asked = scanner.line.now;
    EXPECT_FALSE(scanner.ask("READ?", 100).empty());
    return seconds_between(asked, scanner.line.last_sent) - 0.005 - 10 * 0.03;
  };
  EXPECT_NEAR(duration("FRES:NPLC 10,(@101:110)"), 10 * 4 * 10 / 50.0, 1e-6);
  EXPECT_NEAR(duration("FRES:OCOM OFF,(@101:110)"), 10 * 2 * 5 / 50.0, 1e-6);
  EXPECT_NEAR(duration("TRIG:DEL 0.25"), 10 * (4 * 5 / 50.0 + 0.25), 1e-6);
  EXPECT_NEAR(
      duration(
          "FRES:AVER:TCON REP,(@101:110);:FRES:AVER:COUN 3,(@101:110);:FRES:AVER ON,(@101:110)"),
      10 * 3 * 4 * 5 / 50.0, 1e-6);
}

TEST(Keithley, EachProbeIsReadWhenItsTurnComes) {
  Scanner scanner;
  scanner.set_up(2);
  scanner.line.say("READ?\n");
  scanner.line.hear(0.6);  // 101 is done, 102 not yet
  scanner.plant.ohm[101] = scanner.plant.ohm[102] = 1100;
  EXPECT_THAT(scanner.line.hear(1),
              testing::AllOf(HasSubstr("+1.08100000E+03,"), HasSubstr("+1.10000000E+03,")));
}

TEST(Keithley, FetchRepeatsWithoutMeasuring) {
  Scanner scanner;
  EXPECT_EQ(scanner.error_after("FETC?"), "-230,\"Data corrupt or stale\"\n");
  scanner.set_up();
  const std::string read = scanner.ask("READ?", 10);
  EXPECT_EQ(scanner.ask("FETC?"), read);
  EXPECT_EQ(scanner.ask("FETCH?"), read);
}

TEST(Keithley, GluesUnitsOnByDefault) {
  Scanner scanner;
  scanner.set_up(2);
  scanner.ask("FORM:ELEM READ,UNIT,TST,RNUM");
  EXPECT_THAT(scanner.ask("READ?", 10),
              testing::MatchesRegex("\\+1\\.08100000E\\+03OHM4W,\\+[0-9.]+SECS,\\+0RDNG#,"
                                    "\\+1\\.08200000E\\+03OHM4W,\\+[0-9.]+SECS,\\+1RDNG#\n"));
  EXPECT_EQ(Scanner().ask("FORM:ELEM?"), "READ,UNIT,TST,RNUM,,\n");
}

TEST(Keithley, AnOpenProbeIsAReadingNotAnError) {
  Scanner scanner;
  scanner.set_up(3);
  scanner.plant.ohm[102] = std::nan("");
  EXPECT_THAT(scanner.ask("READ?", 10), HasSubstr(",+9.9E37,"));
  scanner.plant.ohm[102] = 1200.001;  // above 120 % of the range
  EXPECT_THAT(scanner.ask("READ?", 10), HasSubstr(",+9.9E37,"));
  EXPECT_EQ(scanner.ask("SYST:ERR?"), "0,\"No error\"\n");
}

TEST(Keithley, LongAndShortFormsAreCaseBlind) {
  Scanner scanner;
  EXPECT_EQ(scanner.ask("sens:fres:nplc 7;:SENSE:FRESISTANCE:NPLCYCLES?"), "+7.00000000E+00\n");
  EXPECT_EQ(scanner.ask("FRESistance:NPLC?"), "+7.00000000E+00\n");
  EXPECT_EQ(scanner.error_after("FRESIS:NPLC?"), "-113,\"Undefined header\"\n") << "neither form";
}

TEST(Keithley, JoinsRepliesOfOneMessage) {
  Scanner scanner;
  EXPECT_EQ(scanner.ask("SAMP:COUN?;:TRIG:COUN?;:ROUT:SCAN:LSEL?"), "1;1;NONE\n");
  EXPECT_EQ(scanner.ask("TRIG:COUN 3;DEL 1;COUN?;*OPC?;DEL?"), "3;1;+1.00000000E+00\n")
      << "the path stays, and common commands leave it alone";
}

TEST(Keithley, ThePathIsStrict) {
  Scanner scanner;
  EXPECT_EQ(scanner.error_after("TRAC:CLE;INIT:CONT OFF"), "-113,\"Undefined header\"\n");
  EXPECT_EQ(scanner.error_after("TRAC:CLE;:INIT:CONT OFF"), "0,\"No error\"\n");
}

TEST(Keithley, NothingMayFollowAnIndefiniteReply) {
  Scanner scanner;
  EXPECT_THAT(scanner.ask("*IDN?;*OPC?"), testing::EndsWith("A02 \n"));
  EXPECT_THAT(scanner.ask("SYST:ERR?"), StartsWith("-440,"));
}

struct ScpiRefusal {
  const char *name, *text, *error;
};
class KeithleyRefuses : public testing::TestWithParam<ScpiRefusal> {};
TEST_P(KeithleyRefuses, WithTheStandardCode) {
  Scanner scanner;
  EXPECT_THAT(scanner.error_after(GetParam().text),
              StartsWith(std::string(GetParam().error) + ",\""));
  EXPECT_EQ(scanner.ask("SYST:ERR?"), "0,\"No error\"\n");
}
INSTANTIATE_TEST_SUITE_P(
    Table, KeithleyRefuses,
    testing::Values(ScpiRefusal{"UnknownHeader", "FOO:BAR 1", "-113"},
                    ScpiRefusal{"UnknownQuery", "TEMP:RTD?", "-113"},
                    ScpiRefusal{"QueryOfACommand", "*RST?", "-113"},
                    ScpiRefusal{"InvalidCharacter", "\x80\x81", "-101"},
                    ScpiRefusal{"Syntax", "FRES::NPLC 5", "-102"},
                    ScpiRefusal{"LongMnemonic", "ABCDEFGHIJKLMNOP", "-112"},
                    ScpiRefusal{"MissingParameter", "SAMP:COUN", "-109"},
                    ScpiRefusal{"TooManyParameters", "SAMP:COUN 1,2", "-108"},
                    ScpiRefusal{"NotANumber", "SAMP:COUN 1x", "-104"},
                    ScpiRefusal{"OutOfRange", "SAMP:COUN 0", "-222"},
                    ScpiRefusal{"Nplc", "FRES:NPLC 51", "-222"},
                    ScpiRefusal{"ChannelOfNoCard", "ROUT:SCAN (@201)", "-222"},
                    ScpiRefusal{"NoList", "ROUT:SCAN 101", "-102"},
                    ScpiRefusal{"IllegalWord", "TRIG:SOUR NOW", "-224"},
                    ScpiRefusal{"UnknownFunction", "FUNC 'FOO'", "-224"},
                    ScpiRefusal{"TwoAtOnce", "ROUT:CLOS (@101,102)", "-223"},
                    ScpiRefusal{"UpperHalf", "FUNC 'FRES',(@111)", "-221"},
                    ScpiRefusal{"NotItsFunction", "FRES:NPLC 5,(@101)", "-221"},
                    ScpiRefusal{"NothingToTrigger", "*TRG", "-211"},
                    ScpiRefusal{"InitWhileContinuous", "INIT:CONT ON;:INIT", "-213"},
                    ScpiRefusal{"ReadWhileContinuous", "INIT:CONT ON;:READ?", "-213"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(Keithley, SwitchesLoosenThePairingAndTheOrder) {
  EXPECT_THAT(Scanner({{"pairing_error", "524"}}).error_after("FUNC 'FRES',(@111)"),
              StartsWith("524,"));
  EXPECT_THAT(Scanner({{"parameter_needs_function", "false"}}).error_after("FRES:NPLC 5,(@101)"),
              StartsWith("0,"));
}

TEST(Keithley, SampleCountAndContinuousInitiationExclude) {
  Scanner scanner;
  EXPECT_THAT(scanner.error_after("INIT:CONT ON;:SAMP:COUN 2"), StartsWith("-221,"));
  EXPECT_THAT(scanner.error_after("INIT:CONT OFF;:SAMP:COUN 2;:INIT:CONT ON"), StartsWith("-221,"));
  scanner.ask("SYST:PRES");
  EXPECT_EQ(scanner.ask("INIT:CONT?", 1), "1\n") << "the preset turns it on";
  scanner.ask("*RST");
  EXPECT_EQ(scanner.ask("INIT:CONT?", 1), "0\n");
}

TEST(Keithley, AFourWireFunctionShrinksTheScanSilentlyAndForGood) {
  Scanner scanner;
  scanner.ask("ROUT:SCAN (@101:120)");
  scanner.ask("FUNC 'FRES',(@101:110)");
  EXPECT_EQ(scanner.ask("ROUT:SCAN?"), "(@101:110)\n");
  scanner.ask("FUNC 'VOLT',(@101:110)");
  EXPECT_EQ(scanner.ask("ROUT:SCAN?"), "(@101:110)\n") << "it does not grow back";
  EXPECT_EQ(scanner.ask("SYST:ERR?"), "0,\"No error\"\n");
}

TEST(Keithley, A40ChannelCardPairsItsTwenties) {
  Scanner scanner({{"slot1", "7708"}});
  scanner.ask("FUNC 'FRES',(@101:113)");
  scanner.ask("ROUT:SCAN (@101:140)");
  EXPECT_EQ(scanner.ask("ROUT:SCAN?"), "(@101:120,134:140)\n");
  EXPECT_THAT(scanner.error_after("FUNC 'FRES',(@121)"), StartsWith("-221,"));
}

TEST(Keithley, OrderOfTheScanIsASwitch) {
  Scanner ascending, typed({{"scan_order", "typed"}});
  EXPECT_EQ(ascending.ask("ROUT:SCAN (@103,101,102);SCAN?"), "(@101:103)\n");
  EXPECT_EQ(typed.ask("ROUT:SCAN (@103,101,102);SCAN?"), "(@103,101,102)\n");
}

TEST(Keithley, TheErrorQueueOverflows) {
  Scanner scanner;
  for (int i = 0; i < 12; ++i) scanner.ask("FOO");
  for (int i = 0; i < 9; ++i) EXPECT_THAT(scanner.ask("SYST:ERR?"), StartsWith("-113,"));
  EXPECT_EQ(scanner.ask("SYST:ERR?"), "-350,\"Queue overflow\"\n");
  EXPECT_EQ(scanner.ask("SYST:ERR?"), "0,\"No error\"\n");
}

TEST(Keithley, AMessageDuringAScanInterruptsIt) {
  Scanner scanner;
  scanner.set_up();
  scanner.line.ask("READ?\n", 1);
  EXPECT_EQ(scanner.ask("SAMP:COUN?", 20), "10\n") << "the scan's answer is lost";
  EXPECT_EQ(scanner.ask("SYST:ERR?"), "-410,\"Query interrupted\"\n");
}

TEST(Keithley, OrWaitsItsTurnWhenSwitched) {
  Scanner scanner({{"interrupt", "false"}});
  scanner.set_up();
  scanner.line.ask("READ?\n", 1);
  EXPECT_THAT(scanner.ask("SAMP:COUN?", 20), testing::MatchesRegex("\\+1\\.081[^\n]*\n10\n"));
}

TEST(Keithley, DeviceClearBreaksAScanOff) {
  for (const char* clear : {"\x03", "\x18"}) {
    Scanner scanner;
    scanner.set_up();
    scanner.line.ask("READ?\nFOO", 1);
    EXPECT_EQ(scanner.line.ask(clear, 20), "");
    EXPECT_EQ(scanner.ask("SYST:ERR?"), "0,\"No error\"\n")
        << "neither the scan nor half a message is left";
  }
}

TEST(Keithley, ResetTakesItsTime) {
  Scanner scanner;
  scanner.line.say("*RST\n*OPC?\n");
  EXPECT_EQ(scanner.line.hear(0.19), "");
  EXPECT_EQ(scanner.line.hear(0.1), "1\n");
}

TEST(Keithley, OpcWaitsForTheAcquisition) {
  Scanner scanner;
  scanner.set_up(2);
  scanner.line.say("INIT\n*OPC?\n");
  EXPECT_EQ(scanner.line.hear(0.8), "");
  EXPECT_EQ(scanner.line.hear(0.1), "1\n");
  EXPECT_THAT(scanner.ask("FETC?"), StartsWith("+1.081"));
}

TEST(Keithley, LaterScansOverwriteEarlierOnes) {
  Scanner scanner;
  scanner.set_up(2);
  scanner.line.say("TRIG:COUN 3\nREAD?\n");
  scanner.line.hear(2.0);  // in the third scan
  scanner.plant.ohm[101] = 1100;
  const std::string reply = scanner.line.hear(5);
  EXPECT_EQ(std::count(reply.begin(), reply.end(), ','), 5);
  EXPECT_THAT(reply, StartsWith("+1.10000000E+03"));
}

TEST(Keithley, TheBusTriggersAScan) {
  Scanner scanner;
  scanner.set_up(2);
  scanner.line.say("TRIG:SOUR BUS\nINIT\n");
  scanner.line.hear(10);
  EXPECT_THAT(scanner.error_after("FETC?"), StartsWith("-230,"));
  scanner.ask("*TRG", 2);
  EXPECT_THAT(scanner.ask("FETC?"), StartsWith("+1.081"));
}

TEST(Keithley, TheBufferIsReadInSlices) {
  Scanner scanner;
  scanner.set_up(2);
  scanner.ask("FORM:ELEM READ;:TRAC:POIN 4;FEED SENS;FEED:CONT NEXT;:TRIG:COUN 2;:INIT");
  scanner.line.hear(5);
  EXPECT_EQ(scanner.ask("TRAC:DATA?"),
            "+1.08100000E+03,+1.08200000E+03,+1.08100000E+03,+1.08200000E+03\n");
  EXPECT_EQ(scanner.ask("TRAC:DATA:SEL? 1,2"), "+1.08200000E+03,+1.08100000E+03\n");
  EXPECT_EQ(scanner.ask("TRAC:FEED:CONT?"), "NEV\n") << "full";
  EXPECT_THAT(scanner.error_after("TRAC:DATA:SEL? 3,2"), StartsWith("-222,"));
}

TEST(Keithley, ItsPt100IsNotIec60751) {
  // PROTOCOLS section 1: an IEC probe reads +2.8 mK at 20 degC with the built-in type, and well
  // with alpha .00385055.
  Scanner scanner;
  scanner.plant.ohm[101] = 107.79350;  // IEC 60751, 20 degC, R0 = 100 ohm
  scanner.ask("FUNC 'TEMP',(@101)");
  scanner.ask("TEMP:TRAN FRTD,(@101);FRTD:TYPE PT100,(@101)");
  scanner.ask("FORM:ELEM READ;:ROUT:SCAN (@101);SCAN:LSEL INT");
  EXPECT_NEAR(std::stod(scanner.ask("READ?", 5)), 20.003, 0.0006);
  scanner.ask(
      "TEMP:FRTD:TYPE USER,(@101);RZER 100,(@101);ALPH .00385055,(@101);BETA .10863,(@101);DELT "
      "1.4999,(@101)");
  EXPECT_EQ(scanner.ask("TEMP:FRTD:RZER? (@101)"), "+1.00000000E+02\n");
  EXPECT_NEAR(std::stod(scanner.ask("READ?", 5)), 20.000, 0.0006);
  scanner.ask("UNIT:TEMP F");
  EXPECT_NEAR(std::stod(scanner.ask("READ?", 5)), 68.0, 0.001);
  EXPECT_EQ(scanner.ask("SYST:ERR?"), "0,\"No error\"\n");
}

TEST(Keithley, UserProbesMayBeMissing) {
  Scanner scanner({{"user_rtd", "false"}});
  EXPECT_THAT(scanner.error_after("TEMP:FRTD:RZER 1000"), StartsWith("-113,"));
}

TEST(Keithley, APt1000OnABuiltInTypeOverflows) {
  Scanner scanner;
  scanner.ask("FUNC 'TEMP',(@101);:TEMP:TRAN FRTD,(@101)");
  scanner.ask("FORM:ELEM READ;:ROUT:SCAN (@101);SCAN:LSEL INT");
  EXPECT_EQ(scanner.ask("READ?", 5), "+9.9E37\n");
}

TEST(Keithley, TwoWiresAddTheirLeads) {
  Scanner scanner;
  scanner.ask("FUNC 'RES',(@101);:FORM:ELEM READ;:ROUT:SCAN (@101);SCAN:LSEL INT");
  EXPECT_EQ(scanner.ask("READ?", 5), "+1.08200000E+03\n");
}

TEST(KeithleySerial, RunsACommandAtCarriageReturnAndAnswersWithItsTerminator) {
  Scanner scanner({{"serial_terminator", "\\n\\r"}, {"serial_baud", "0"}}, Link::serial);
  EXPECT_EQ(scanner.line.ask("SAMP:COUN?\n", 1), "") << "a line feed does not run it";
  scanner.line.ask("\r", 1);
  EXPECT_EQ(scanner.line.ask("SAMP:COUN?\r", 1), "1\n\r");
}

TEST(KeithleySerial, RepliesTakeTheTimeOfTheirBytes) {
  Scanner scanner({{"serial_baud", "300"}}, Link::serial);
  scanner.line.say("\x03*OPT?\r");  // drop what the fixture typed with line feeds
  EXPECT_EQ(scanner.line.hear(0.56), "") << "7 bytes of 10 bits at 300 baud, then 10 bytes";
  EXPECT_EQ(scanner.line.hear(0.02), "7700,NONE\r");
}

TEST(KeithleySerial, CommandsTakeTheTimeOfTheirBytesBeforeTheNextQuery) {
  Scanner scanner({{"serial_baud", "4800"}}, Link::serial);
  scanner.line.ask("\x03", 1);
  const std::string command = "FRES:NPLC 5,(@101:110)\r";
  std::string batch;
  for (int i = 0; i < 17; ++i) batch += command;  // 391 bytes
  EXPECT_EQ(scanner.line.ask(batch + "*OPC?\r", 0.82), "") << "397 bytes take 0.827 s";
  EXPECT_EQ(scanner.line.hear(0.05), "1\r");
}

TEST(KeithleySerial, ADeviceClearComesInItsTurn) {
  Scanner scanner({{"serial_baud", "300"}}, Link::serial);
  scanner.line.ask("\x03", 1);
  scanner.line.say("*OPT?\r\x03*IDN?\r");
  EXPECT_EQ(scanner.line.hear(0.21), "");
  EXPECT_THAT(scanner.line.hear(5), StartsWith("KEITHLEY")) << "the cards are not told any more";
}

TEST(Keithley, AnEndlessMessageIsAnOverrun) {
  Scanner scanner;
  scanner.line.say(std::string(1'000'000, 'A'));
  scanner.line.say("\n");
  EXPECT_EQ(scanner.ask("SYST:ERR?"), "-363,\"Input buffer overrun\"\n");
}

}  // namespace
}  // namespace driftwise::simulated
