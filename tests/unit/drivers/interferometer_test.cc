#include "drivers/interferometer_adapter/interferometer_adapter.h"
#include "tests/unit/drivers/driver_fixture.h"

namespace driftwise {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using tests::expect;
using tests::hang_up;
using tests::Script;
using tests::send;

class InterferometerLoop : public tests::DriverFixture {
 protected:
  DeviceDescription laser(std::map<std::string, std::string> options = {}) {
    auto out = device("laser-x", "interferometer-adapter");
    out.become<LengthSettings>().channel = {"x", "mm"};
    out.options = std::move(options);
    out.options.emplace("dead_path_mm", "120");
    out.options.emplace("sample_rate_hz", "1e8");
    return out;
  }
  Instrument& make(const DeviceDescription& description) {
    auto made = drivers::make_interferometer_adapter(description, context.get_executor(), clock);
    EXPECT_TRUE(made) << made.error().message;
    instrument = std::move(*made);
    return *instrument;
  }
  static Script set_up_and(const Script& rest) {
    Script out{expect("IDN?\n"), send("OK SIOS SP-2000 0471 ch=2\n"), expect("AVG 4096\n"),
               send("OK\n"),     expect("DEADPATH 1 120\n"),          send("OK\n")};
    out.insert(out.end(), rest.begin(), rest.end());
    return out;
  }
  static std::string measured(const char* mean_nm, const char* more = "status=0x0010",
                              int offset_s = 0) {
    const std::string t0 = std::to_string(tests::kTestEpoch.utc_ns / 1'000'000'000 + offset_s);
    return std::string("OK ch=1 n=4096 mean_nm=") + mean_nm +
           " std_nm=1.5 t_air_C=20.5 t_age_s=0.5 level_pct=80 " + more + " t0=" + t0 +
           ".25 t1=" + t0 + ".75\n";
  }
  std::unique_ptr<Instrument> instrument;
};

TEST_F(InterferometerLoop, ReadsLengthSpreadAirAndLevelWithTheDevicesTime) {
  peer.on_connection(set_up_and({expect("MEAS? 1\n"), send(measured("1500000.25"))}));
  const auto before = clock.now().utc;
  const auto reading = run(make(laser()).read());
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_DOUBLE_EQ(*reading->find("x_mm"), 1.50000025);
  EXPECT_EQ(*reading->find("x_std_nm"), 1.5);
  EXPECT_EQ(*reading->find("air_degC"), 20.5);
  EXPECT_EQ(*reading->find("level_pct"), 80);
  EXPECT_EQ(reading->end - reading->start, 500ms);
  // The adapter's clock counts by its measured offset: its stamps lie after the question.
  EXPECT_GE(reading->start, before);
  EXPECT_LT(reading->start - before, 1s);
}

TEST_F(InterferometerLoop, SendsTheDeadPathBeforeEveryZero) {
  auto second = laser({{"channel", "2"}});
  peer.on_connection({expect("IDN?\n"), send("OK SIOS SP-2000 0471 ch=2\n"), expect("AVG 4096\n"),
                      send("OK\n"), expect("DEADPATH 2 120\n"), send("OK\n"),
                      expect("DEADPATH 2 120\n"), send("OK\n"), expect("ZERO 2\n"), send("OK\n")});
  EXPECT_TRUE(run(make(second).zero()));
  EXPECT_TRUE(peer.finished());
}

TEST_F(InterferometerLoop, DoesNotTrustALengthWhoseAdapterMayHaveRestarted) {
  peer.on_connection(set_up_and({expect("DEADPATH 1 120\n"), send("OK\n"), expect("ZERO 1\n"),
                                 send("OK\n"), expect("MEAS? 1\n"), hang_up()}));
  peer.on_connection(set_up_and({expect("DEADPATH 1 120\n"), send("OK\n"), expect("ZERO 1\n"),
                                 send("OK\n"), expect("MEAS? 1\n"), send(measured("7"))}));
  make(laser());
  ASSERT_TRUE(run(instrument->zero()));
  EXPECT_EQ(run(instrument->read()).error().reason, "LINK_LOST");
  const auto lost = run(instrument->read());
  EXPECT_EQ(lost.error().code, ErrorCode::failed_precondition);
  EXPECT_EQ(lost.error().reason, "BEAM_LOST");
  ASSERT_TRUE(run(instrument->zero()));
  EXPECT_TRUE(run(instrument->read()));
}

// One that was restarted without a new connection averages as it was delivered.
TEST_F(InterferometerLoop, SetsAnAdapterUpAnewThatForgotItAndDoesNotTrustItsZero) {
  std::string by_delivery = measured("7");
  by_delivery.replace(by_delivery.find("n=4096"), 6, "n=2048");
  peer.on_connection(set_up_and({expect("DEADPATH 1 120\n"), send("OK\n"),
                                 expect("ZERO 1\n"),         send("OK\n"),
                                 expect("MEAS? 1\n"),        send(by_delivery),
                                 expect("IDN?\n"),           send("OK SIOS SP-2000 0471 ch=2\n"),
                                 expect("IDN?\n"),           send("OK SIOS SP-2000 0471 ch=2\n"),
                                 expect("AVG 4096\n"),       send("OK\n"),
                                 expect("DEADPATH 1 120\n"), send("OK\n"),
                                 expect("DEADPATH 1 120\n"), send("OK\n"),
                                 expect("ZERO 1\n"),         send("OK\n"),
                                 expect("MEAS? 1\n"),        send(measured("8"))}));
  make(laser());
  ASSERT_TRUE(run(instrument->zero()));
  EXPECT_EQ(run(instrument->read()).error().reason, "BAD_REPLY");
  EXPECT_EQ(run(instrument->read()).error().reason, "BEAM_LOST") << "it counts from anywhere";
  ASSERT_TRUE(run(instrument->zero()));
  EXPECT_TRUE(run(instrument->read()));
  EXPECT_EQ(instrument->health().reconnects, 0);
  EXPECT_TRUE(peer.finished());
}

TEST_F(InterferometerLoop, PassesTheDevicesRefusalsOn) {
  peer.on_connection(set_up_and({expect("MEAS? 1\n"), send("ERR 3 beam break\n"),
                                 expect("MEAS? 1\n"), send(measured("1", "status=0x0000")),
                                 expect("MEAS? 1\n"), send(measured("1", "status=0x0012"))}));
  make(laser());
  EXPECT_EQ(run(instrument->read()).error().reason, "BEAM_LOST");
  EXPECT_EQ(run(instrument->read()).error().reason, "LASER_UNSTABLE");
  EXPECT_EQ(run(instrument->read()).error().reason, "LOW_LEVEL");
  EXPECT_EQ(instrument->health().reconnects, 0);
}

TEST_F(InterferometerLoop, NeverTakesALateMeasurementForTheNextOne) {
  peer.on_connection(set_up_and({expect("MEAS? 1\n"), expect("IDN?\n"), send(measured("111")),
                                 send("OK SIOS SP-2000 0471 ch=2\n"), expect("IDN?\n"),
                                 send("OK SIOS SP-2000 0471 ch=2\n"), expect("MEAS? 1\n"),
                                 send(measured("222"))}));
  make(laser());
  EXPECT_EQ(run(instrument->read()).error().code, ErrorCode::deadline_exceeded);
  const auto next = run(instrument->read());
  ASSERT_TRUE(next) << next.error().message;
  EXPECT_DOUBLE_EQ(*next->find("x_mm"), 222e-6);
}

// Issue 11, number 12.
TEST_F(InterferometerLoop, TakesAnAdapterWhoseClockIsAnHourOffByItsMeasuredOffset) {
  peer.on_connection(set_up_and({expect("MEAS? 1\n"), send(measured("1", "status=0x0010", 3600))}));
  const auto before = clock.now().utc;
  const auto reading = run(make(laser()).read());
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_LT(seconds_from(reading->end - before), 60) << "in cell time, not in the adapter's";
  ASSERT_TRUE(instrument->health().clock_offset);
  EXPECT_NEAR(seconds_from(*instrument->health().clock_offset), 3600, 60);
}

TEST_F(InterferometerLoop, UsesNoReadingDuringWhichTheAdaptersClockWasSet) {
  peer.on_connection(set_up_and({expect("MEAS? 1\n"), send(measured("1")), expect("MEAS? 1\n"),
                                 send(measured("2", "status=0x0010", 3600)), expect("MEAS? 1\n"),
                                 send(measured("3", "status=0x0010", 3600))}));
  make(laser());
  ASSERT_TRUE(run(instrument->read()));
  const auto jumped = run(instrument->read());
  ASSERT_FALSE(jumped);
  EXPECT_EQ(jumped.error().reason, "CLOCK_JUMPED");
  EXPECT_THAT(jumped.error().message, testing::AnyOf(HasSubstr("+3599."), HasSubstr("+3600.")));
  EXPECT_TRUE(run(instrument->read())) << "the next one counts by the new offset";
  EXPECT_EQ(instrument->health().clock_jumps, 1);
}

TEST_F(InterferometerLoop, RefusesAChannelThatTheAdapterDoesNotHave) {
  peer.on_connection({expect("IDN?\n"), send("OK SIOS SP-2000 0471 ch=2\n")});
  EXPECT_EQ(run(make(laser({{"channel", "3"}})).prepare()).error().reason, "NO_CHANNEL");
}

TEST_F(InterferometerLoop, LeavesAnOldAirTemperatureOut) {
  peer.on_connection(set_up_and({expect("MEAS? 1\n"), send(measured("1"))}));
  const auto reading = run(make(laser({{"max_air_age_s", "0.1"}, {"level_channel", ""}})).read());
  ASSERT_TRUE(reading);
  EXPECT_TRUE(is_missing(*reading->find("air_degC")));
  EXPECT_EQ(reading->find("level_pct"), nullptr);
}

TEST_F(InterferometerLoop, ChecksItsDescription) {
  auto none = laser();
  none.settings = StabiliserSettings{};
  EXPECT_EQ(
      drivers::make_interferometer_adapter(none, context.get_executor(), clock).error().reason,
      "NO_LENGTH");
  EXPECT_EQ(drivers::make_interferometer_adapter(laser({{"samples", "4000"}}),
                                                 context.get_executor(), clock)
                .error()
                .reason,
            "BAD_OPTION");
  using Option = std::pair<const char*, const char*>;
  for (const auto& [name, value] :
       {Option{"air_channel", "air"}, Option{"air_channel", "x_std_nm"},
        Option{"level_channel", "x_mm"}, Option{"level_channel", "support_power_pct"}})
    EXPECT_EQ(
        drivers::make_interferometer_adapter(laser({{name, value}}), context.get_executor(), clock)
            .error()
            .reason,
        "BAD_CHANNEL")
        << name << " = " << value;
}

}  // namespace
}  // namespace driftwise
