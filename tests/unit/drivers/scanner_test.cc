#include "drivers/keithley_2701/keithley_2701.h"
#include "drivers/keithley_2701/platinum_resistance.h"
#include "tests/unit/drivers/driver_fixture.h"
#include "tests/unit/drivers/pty_peer.h"

namespace driftwise {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;
using tests::expect;
using tests::hang_up;
using tests::Script;
using tests::send;

constexpr const char* kIdentity = "KEITHLEY INSTRUMENTS INC.,MODEL 2701,1234567,A09  /A02\n";

class ScannerLoop : public tests::DriverFixture {
 protected:
  // At 60 x a scan's time-out (3 s and more) is soon over.
  ScannerLoop() { clock.run_at(60); }

  DeviceDescription scanner(std::map<std::string, std::string> options = {}) {
    auto out = device("scanner", "keithley-2701");
    out.timeout_s = 1;
    out.become<TemperatureSettings>().probes.push_back(
        {{"t01", "degC"}, 101, 1000.0, 3.9083e-3, -5.775e-7, "", "robot", 0});
    out.become<TemperatureSettings>().probes.push_back(
        {{"t02", "degC"}, 102, 999.9, 3.9083e-3, -5.775e-7, "", "robot", 0});
    out.options = std::move(options);
    return out;
  }
  Instrument& make(const DeviceDescription& description) {
    auto made = drivers::make_keithley_2701(description, context.get_executor(), clock);
    EXPECT_TRUE(made) << made.error().message;
    instrument = std::move(*made);
    return *instrument;
  }
  static Script set_up(std::string end = "\n", const char* list = "(@101,102)\n",
                       std::vector<const char*> errors = {}) {
    return plus({expect("\x03" + end), expect("*IDN?" + end), send(kIdentity)},
                set_up_from_reset(end, list, std::move(errors)));
  }
  // On the connection of before, with what the queue says of before.
  static Script set_up_again(std::vector<const char*> queue = {}) {
    Script out{expect("\x03\n"), expect("*IDN?\n"), send(kIdentity)};
    queue.push_back("0,\"No error\"\n");
    for (const char* error : queue) {
      out.push_back(expect("SYST:ERR?\n"));
      out.push_back(send(error));
    }
    return plus(out, set_up_from_reset());
  }
  // *OPC? ends each batch of commands (2700 manual, 10-19).
  static Script set_up_from_reset(std::string end = "\n", const char* list = "(@101,102)\n",
                                  std::vector<const char*> errors = {}) {
    Script out{expect("*RST" + end), expect("*CLS" + end),  expect("*OPC?" + end),
               send("1\n"),          expect("*OPT?" + end), send("7708,NONE\n")};
    for (const char* command : {"TRAC:CLE", "INIT:CONT OFF", "FORM:ELEM READ,CHAN,TST",
                                "TRIG:SOUR IMM", "TRIG:COUN 1", "TRIG:DEL 0", "ROUT:SCAN:LSEL NONE",
                                "FUNC 'FRES',(@101,102)", "FRES:RANG 1000,(@101,102)",
                                "FRES:OCOM ON,(@101,102)", "FRES:NPLC 5,(@101,102)", "*OPC?"})
      out.push_back(expect(command + end));
    out.push_back(send("1\n"));
    for (const char* command : {"SAMP:COUN 2", "ROUT:SCAN (@101,102)", "ROUT:SCAN:TSO IMM",
                                "ROUT:SCAN:LSEL INT", "*OPC?"})
      out.push_back(expect(command + end));
    out.push_back(send("1\n"));
    out.push_back(expect("ROUT:SCAN?" + end));
    out.push_back(send(list));
    errors.push_back("0,\"No error\"\n");
    for (const char* error : errors) {
      out.push_back(expect("SYST:ERR?" + end));
      out.push_back(send(error));
    }
    return out;
  }
  static Script plus(Script a, const Script& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
  }
  std::unique_ptr<Instrument> instrument;
};

TEST_F(ScannerLoop, TurnsOhmsIntoTemperaturesWithEachProbesOwnConstants) {
  peer.on_connection(plus(set_up(), {expect("READ?\n"), send("+1.07793E+03,+101,"),
                                     send("+1.000E+01,+9.9E37,+102,+1.005E+01\n")}));
  make(scanner());
  const auto reading = run(instrument->read());
  ASSERT_TRUE(reading) << reading.error().message;
  ASSERT_EQ(reading->values.size(), 2u);
  EXPECT_NEAR(*reading->find("t01_degC"), platinum::degc_from_ohm(1077.93, {}), 1e-12);
  EXPECT_NEAR(*reading->find("t01_degC"), 20.0, 0.02);
  EXPECT_TRUE(is_missing(*reading->find("t02_degC"))) << "an open probe is missing, no error";
  EXPECT_LT(reading->start, reading->end);
  EXPECT_LE(reading->end, clock.now().utc);
}

TEST_F(ScannerLoop, FollowsTheOrderOfTheWire) {
  peer.on_connection(plus(set_up(), {expect("READ?\n"), send("1078,0.5,102,1077,0.1,101\n"),
                                     expect("READ?\n"), send("1088,1.5,102,1087,1.1,101\n"),
                                     expect("READ?\n"), send("1077,101,2.1,1078,102,2.5\n")}));
  make(scanner());
  EXPECT_NEAR(*run(instrument->read())->find("t01_degC"), platinum::degc_from_ohm(1077, {}), 1e-12);
  const auto second = run(instrument->read());
  EXPECT_NEAR(*second->find("t01_degC"), platinum::degc_from_ohm(1087, {}), 1e-12);
  EXPECT_EQ(second->sequence, 2);
  EXPECT_EQ(run(instrument->read()).error().reason, "WRONG_CHANNEL")
      << "the order does not change by itself";
}

TEST_F(ScannerLoop, SendsTheConfiguredTerminator) {
  peer.on_connection(set_up("\r\n"));
  EXPECT_TRUE(run(make(scanner({{"terminator", "crlf"}})).prepare()));
  EXPECT_EQ(instrument->health().identity,
            "KEITHLEY INSTRUMENTS INC.,MODEL 2701,1234567,A09  /A02 [7708,NONE]");
}

TEST_F(ScannerLoop, NoticesThatTheScanListShrank) {
  auto script = set_up("\n", "(@101)\n");
  script.erase(script.end() - 2, script.end());
  peer.on_connection(script);
  const auto done = run(make(scanner()).prepare());
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().reason, "SCAN_LIST");
  EXPECT_THAT(done.error().message, AllOf(HasSubstr("(@101,102)"), HasSubstr("\"(@101)\\n\"")));
}

TEST_F(ScannerLoop, NamesEveryErrorOfTheSetUp) {
  peer.on_connection(
      set_up("\n", "(@101:102)\n",
             {"-221,\"Settings conflict\"\n", "-222,\"Parameter data out of range\"\n"}));
  const auto done = run(make(scanner()).prepare());
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().reason, "SET_UP");
  EXPECT_THAT(done.error().message, AllOf(HasSubstr("-221 Settings conflict"), HasSubstr("-222")));
}

TEST_F(ScannerLoop, ReadsAQueueThatNeverEndsTwelveTimes) {
  const std::vector<const char*> errors(11, "-350,\"Queue overflow\"\n");
  auto script = set_up("\n", "(@101,102)\n", errors);
  script.back() = send("-350,\"Queue overflow\"\n");
  peer.on_connection(script);
  EXPECT_EQ(run(make(scanner()).prepare()).error().reason, "SET_UP");
  EXPECT_TRUE(peer.finished());
}

TEST_F(ScannerLoop, RefusesAnotherDevice) {
  peer.on_connection({expect("\x03\n"), expect("*IDN?\n"), send("ACME,DMM6500,1,1\n")});
  const auto done = run(make(scanner()).prepare());
  EXPECT_EQ(done.error().reason, "WRONG_DEVICE");
  EXPECT_THAT(done.error().message, HasSubstr("ACME"));
}

// On a serial line a scanner that lost its mains comes back without a new connection, with the same
// identity and without its set-up.
TEST_F(ScannerLoop, ClearsTheDeviceAfterATimeoutAndSetsItUpAnew) {
  peer.on_connection(
      plus(plus(plus(set_up(), {expect("READ?\n"), send("1077,101,"), expect("\x03*IDN?\n"),
                                send("0.1,1078,102,0.5\n"), send(kIdentity)}),
                set_up_again()),
           {expect("READ?\n"), send("1090,101,1.1,1078,102,1.5\n")}));
  make(scanner());
  const auto late = run(instrument->read());
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, ErrorCode::deadline_exceeded);
  const auto next = run(instrument->read());
  ASSERT_TRUE(next) << next.error().message;
  EXPECT_NEAR(*next->find("t01_degC"), platinum::degc_from_ohm(1090, {}), 1e-12)
      << "not the late scan";
  EXPECT_EQ(instrument->health().reconnects, 0);
}

// *CLS would erase what the scanner has to say about its own failure.
TEST_F(ScannerLoop, ReadsTheErrorQueueBeforeItIsErased) {
  auto script = plus(set_up(), {expect("READ?\n"), expect("\x03*IDN?\n"), send(kIdentity)});
  script = plus(script, set_up_again({"-410,\"Query interrupted\"\n"}));
  peer.on_connection(plus(script, {expect("READ?\n"), send("1090,101,1.1,1078,102,1.5\n")}));
  make(scanner());
  EXPECT_EQ(run(instrument->read()).error().reason, "TIMEOUT");
  const auto next = run(instrument->read());
  ASSERT_TRUE(next) << next.error().message;
  EXPECT_THAT(instrument->health().last_error, HasSubstr("-410 Query interrupted"));
}

TEST_F(ScannerLoop, AddsTheErrorQueueOfBeforeToTheErrorOfTheSetUp) {
  auto script = plus(set_up(), {expect("READ?\n"), expect("\x03*IDN?\n"), send(kIdentity),
                                expect("\x03\n"), expect("*IDN?\n"), send(kIdentity),
                                expect("SYST:ERR?\n"), send("-363,\"Input buffer overrun\"\n"),
                                expect("SYST:ERR?\n"), send("0,\"No error\"\n")});
  peer.on_connection(
      plus(script, set_up_from_reset("\n", "(@101,102)\n", {"-221,\"Settings conflict\"\n"})));
  make(scanner());
  EXPECT_EQ(run(instrument->read()).error().reason, "TIMEOUT");
  const auto refused = run(instrument->read());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "SET_UP");
  EXPECT_THAT(refused.error().message,
              AllOf(HasSubstr("-221 Settings conflict"), HasSubstr("-363 Input buffer overrun")));
}

class ForgottenSetUp : public ScannerLoop, public testing::WithParamInterface<const char*> {};
TEST_P(ForgottenSetUp, IsSetAnewAfterAScanThatContradictsIt) {
  peer.on_connection(plus(plus(plus(set_up(), {expect("READ?\n"), send(GetParam()),
                                               expect("\x03*IDN?\n"), send(kIdentity)}),
                               set_up_again()),
                          {expect("READ?\n"), send("1090,101,1.1,1078,102,1.5\n")}));
  make(scanner());
  const auto contradicts = run(instrument->read());
  ASSERT_FALSE(contradicts);
  EXPECT_EQ(contradicts.error().code, ErrorCode::data_loss);
  const auto next = run(instrument->read());
  ASSERT_TRUE(next) << next.error().message;
  EXPECT_NEAR(*next->find("t01_degC"), platinum::degc_from_ohm(1090, {}), 1e-12);
  EXPECT_EQ(instrument->health().reconnects, 0);
}
INSTANTIATE_TEST_SUITE_P(Scans, ForgottenSetUp,
                         testing::Values("-1.2345E-05VDC,+0.3SECS,+4RDNG#\n",
                                         "1077,103,0.1,1078,104,0.5\n"));

// A 2700 on RS-232: bytes wait in its queue, and each command takes its time.
TEST(ScannerOnASerialLine, IsSetUpThoughItsCommandsTakeLongerThanItsTimeOut) {
  static constexpr auto kCommand = 30ms;  // 17 of them: twice the time-out
  const tests::PtyPeer peer([](std::string& received) {
    std::string replies;
    for (auto end = received.find('\r'); end != std::string::npos; end = received.find('\r')) {
      auto command = received.substr(0, end);
      received.erase(0, end + 1);
      std::erase(command, '\x03');
      if (command == "*IDN?")
        replies += "KEITHLEY INSTRUMENTS INC.,MODEL 2700,1234567,B09  /A02\r";
      else if (command == "*OPC?")
        replies += "1\r";
      else if (command == "*OPT?")
        replies += "7700,NONE\r";
      else if (command == "ROUT:SCAN?")
        replies += "(@101)\r";
      else if (command == "SYST:ERR?")
        replies += "0,\"No error\"\r";
      else
        std::this_thread::sleep_for(kCommand);
    }
    return replies;
  });
  DeviceDescription described;
  described.id = "scanner";
  described.kind = "keithley-2701";
  described.address = peer.path();
  described.timeout_s = 0.25;
  described.become<TemperatureSettings>().probes.push_back(
      {{"t01", "degC"}, 101, 1000.0, 3.9083e-3, -5.775e-7, "", "robot", 0});
  asio::io_context context{1};
  tests::WallClock clock;
  auto made = drivers::make_keithley_2701(described, context.get_executor(), clock);
  ASSERT_TRUE(made) << made.error().message;
  const auto ready = tests::run(context, (*made)->prepare());
  EXPECT_TRUE(ready) << ready.error().message;
}

TEST_F(ScannerLoop, HasNoZero) { EXPECT_EQ(run(make(scanner()).zero()).error().reason, "NO_ZERO"); }

TEST_F(ScannerLoop, RefusesProbesThatCannotBe) {
  auto twice = scanner();
  twice.become<TemperatureSettings>().probes[1].input = 101;
  EXPECT_EQ(drivers::make_keithley_2701(twice, context.get_executor(), clock).error().reason,
            "BAD_PROBES");
  twice.become<TemperatureSettings>().probes.clear();
  EXPECT_EQ(drivers::make_keithley_2701(twice, context.get_executor(), clock).error().reason,
            "BAD_PROBES");
}

}  // namespace
}  // namespace driftwise
