#include "drivers/lds1000/newport_lds1000.h"
#include "tests/unit/drivers/driver_fixture.h"

namespace driftwise {
namespace {

using testing::HasSubstr;
using tests::expect;
using tests::Script;
using tests::send;

constexpr const char* kSeconds = "1TA,RT,04512,0,2,sec,00102,00241\r";
constexpr const char* kMicroradian = "1TA,RT,04512,1,\xB5rad,00102,00241\r";
constexpr const char* kMicroradian2 = "2TA,RT,04512,1,\xB5rad,00102,00241\r";

class AutocollimatorLoop : public tests::DriverFixture {
 protected:
  DeviceDescription collimator(std::map<std::string, std::string> options = {}) {
    auto out = device("collimator-1", "newport-lds1000");
    out.become<AngleSettings>().angles = {{{"ry", "arcsec"}, 1, 1, 0}};
    out.options = std::move(options);
    return out;
  }
  Instrument& make(const DeviceDescription& description) {
    auto made = drivers::make_newport_lds1000(description, context.get_executor(), clock);
    EXPECT_TRUE(made) << made.error().message;
    instrument = std::move(*made);
    return *instrument;
  }
  static Script identified_and(const Script& rest) {
    Script out{expect("VE\r"),    send("VE LDS1000 Controller Version 3.10\r"),
               expect("TE\r"),    send("TEA\r"),  // what somebody asked before us
               expect("KI100\r"), expect("TE\r"),
               send("TE@\r"),     expect("XI\r"),
               send("XI100\r")};
    out.insert(out.end(), rest.begin(), rest.end());
    return out;
  }
  static Script set_up_and(const Script& rest) {
    Script out = identified_and({expect("1TA\r"), send(kSeconds)});
    out.insert(out.end(), rest.begin(), rest.end());
    return out;
  }
  std::unique_ptr<Instrument> instrument;
};

TEST_F(AutocollimatorLoop, ReadsBetweenTwoGoodStates) {
  peer.on_connection(set_up_and({expect("MS\r"), send("MS@\r"), expect("1TP\r"), send("1TP12.34\r"),
                                 expect("1TA\r"), send(kSeconds), expect("MS\r"), send("MS@\r")}));
  const auto reading = run(make(collimator()).read());
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_EQ(*reading->find("ry_arcsec"), 12.34);
  EXPECT_LE(reading->start, reading->end);
  EXPECT_TRUE(peer.finished());
}

// EDH0170: a value is the mean over the integration constant before it is asked for. What the axes
// did before read() was called, such as their approach, is not in it.
TEST_F(AutocollimatorLoop, ReadsNothingOfTheTimeBeforeItsCall) {
  constexpr auto kIntegration = std::chrono::milliseconds(200);
  Script script{expect("VE\r"),    send("VE LDS1000 Controller Version 3.10\r"),
                expect("TE\r"),    send("TE@\r"),
                expect("KI200\r"), expect("TE\r"),
                send("TE@\r"),     expect("XI\r"),
                send("XI200\r"),   expect("1TA\r"),
                send(kSeconds)};
  for (int k = 0; k < 2; ++k)
    for (const auto& step : {expect("MS\r"), send("MS@\r"), expect("1TP\r"), send("1TP1.5\r"),
                             expect("1TA\r"), send(kSeconds), expect("MS\r"), send("MS@\r")})
      script.push_back(step);
  peer.on_connection(script);
  make(collimator({{"integration_ms", "200"}}));
  for (int k = 0; k < 2; ++k) {
    const CellTime called = clock.now().utc;
    const auto reading = run(instrument->read());
    ASSERT_TRUE(reading) << reading.error().message;
    EXPECT_GE(reading->start, called);
    EXPECT_GE(reading->end - reading->start, kIntegration);
    EXPECT_LE(reading->end, clock.now().utc);
  }
}

TEST_F(AutocollimatorLoop, ReadsTwoAxesWithTheirSignsAndUnits) {
  auto both = collimator();
  both.become<AngleSettings>().angles = {{{"ry", "arcsec"}, 1, -1, 0}, {{"rz", "arcsec"}, 2, 1, 0}};
  peer.on_connection(
      identified_and({expect("1TA\r"), send(kSeconds), expect("2TA\r"), send(kMicroradian2),
                      expect("MS\r"), send("MS@\r"), expect("1TP\r"), send("1TP12.34\r"),
                      expect("2TP\r"), send("2TP48.481368\r"), expect("1TA\r"), send(kSeconds),
                      expect("2TA\r"), send(kMicroradian2), expect("MS\r"), send("MS@\r")}));
  const auto reading = run(make(both).read());
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_EQ(*reading->find("ry_arcsec"), -12.34);
  EXPECT_NEAR(*reading->find("rz_arcsec"), 10.0, 1e-6);
}

// A controller that lost its mains comes back on the same line with the unit of its delivery; the
// same tilt is 97 then, and nothing in the value says so.
TEST_F(AutocollimatorLoop, UsesNoValueOfAControllerWhoseUnitHasChanged) {
  const Script one_read{expect("MS\r"), send("MS@\r"), expect("1TP\r")};
  const auto plus = [](Script a, const Script& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
  };
  Script script = plus(one_read, {send("1TP97.0\r"), expect("1TA\r"), send(kMicroradian)});
  script = plus(script, identified_and({expect("1TA\r"), send(kMicroradian)}));
  script = plus(plus(script, one_read), {send("1TP97.0\r"), expect("1TA\r"), send(kMicroradian),
                                         expect("MS\r"), send("MS@\r")});
  peer.on_connection(set_up_and(script));
  make(collimator());
  const auto changed = run(instrument->read());
  ASSERT_FALSE(changed) << *changed->find("ry_arcsec");
  EXPECT_EQ(changed.error().reason, "WRONG_SET_UP");
  EXPECT_THAT(changed.error().message, HasSubstr("unit urad, increment 1, it was unit sec"));
  const auto again = run(instrument->read());
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_NEAR(*again->find("ry_arcsec"), 20.0, 0.01);
  EXPECT_EQ(instrument->health().reconnects, 0);
  EXPECT_TRUE(peer.finished());
}

TEST_F(AutocollimatorLoop, DropsAValueWhoseSpotWasLostMeanwhile) {
  peer.on_connection(
      set_up_and({expect("MS\r"), send("MS@\r"), expect("1TP\r"), send("1TP0.0\r"), expect("1TA\r"),
                  send(kSeconds), expect("MS\r"), send("MSA\r"), expect("MS\r"), send("MSB\r")}));
  make(collimator());
  const auto dark = run(instrument->read());
  EXPECT_EQ(dark.error().reason, "NO_SPOT");
  EXPECT_THAT(dark.error().message, HasSubstr("wrong power"));
  EXPECT_THAT(run(instrument->read()).error().message, HasSubstr("outside the range"));
  EXPECT_EQ(instrument->health().reconnects, 0);
}

TEST_F(AutocollimatorLoop, RefusesAnotherSetUpThanTheCellFileExpects) {
  peer.on_connection(
      identified_and({expect("1TA\r"), send("1TA,RT,04512,1,\xB5rad,00102,00241\r")}));
  const auto refused = run(make(collimator({{"unit", "sec"}, {"increment", "0.2"}})).prepare());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "WRONG_SET_UP");
  EXPECT_THAT(refused.error().message, HasSubstr("unit urad, increment 1"));
  EXPECT_THAT(refused.error().message, HasSubstr("unit sec, increment 0.2"));
}

TEST_F(AutocollimatorLoop, TellsWhenTheIntegrationConstantIsNotTaken) {
  peer.on_connection({expect("VE\r"), send("VE LDS1000 Controller Version 3.10\r"), expect("TE\r"),
                      send("TE@\r"), expect("KI50000\r"), expect("TE\r"), send("TEC\r")});
  EXPECT_EQ(run(make(collimator({{"integration_ms", "50000"}})).prepare()).error().reason,
            "BAD_PARAMETER");
}

TEST_F(AutocollimatorLoop, NeverTakesALateValueForTheNextOne) {
  Script script{expect("MS\r"), send("MS@\r"),     expect("1TP\r"),
                expect("VE\r"), send("1TP99.9\r"), send("VE LDS1000 Controller Version 3.10\r")};
  const Script anew = set_up_and({expect("MS\r"), send("MS@\r"), expect("1TP\r"), send("1TP1.5\r"),
                                  expect("1TA\r"), send(kSeconds), expect("MS\r"), send("MS@\r")});
  script.insert(script.end(), anew.begin(), anew.end());
  peer.on_connection(set_up_and(script));
  make(collimator());
  EXPECT_EQ(run(instrument->read()).error().code, ErrorCode::deadline_exceeded);
  const auto next = run(instrument->read());
  ASSERT_TRUE(next) << next.error().message;
  EXPECT_EQ(*next->find("ry_arcsec"), 1.5);
}

TEST_F(AutocollimatorLoop, HasNoZero) {
  EXPECT_EQ(run(make(collimator()).zero()).error().reason, "NO_ZERO");
}

TEST_F(AutocollimatorLoop, ChecksItsDescription) {
  auto none = collimator();
  none.become<AngleSettings>().angles.clear();
  EXPECT_EQ(drivers::make_newport_lds1000(none, context.get_executor(), clock).error().reason,
            "NO_ANGLE");
  EXPECT_EQ(
      drivers::make_newport_lds1000(collimator({{"unit", "deg"}}), context.get_executor(), clock)
          .error()
          .reason,
      "BAD_OPTION");
}

}  // namespace
}  // namespace driftwise
