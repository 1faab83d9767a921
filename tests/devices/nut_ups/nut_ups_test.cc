// Supplies that do not say everything, and supplies that calibrate, over upsd's protocol (RFC
// 9271).

#include "drivers/nut_ups/nut_ups.h"

#include "server/core/data/reading.h"
#include "tests/unit/drivers/driver_fixture.h"

namespace driftwise::nut_ups {
namespace {

using tests::expect;
using tests::hang_up;
using tests::Script;
using tests::send;

class UpsLoop : public tests::DriverFixture {
 protected:
  NutUps& make() {
    auto described = device("rack", "nut-ups");
    described.become<SupplySettings>();
    described.options = {{"ups", "rack"}};
    const auto options = read_options(described);
    EXPECT_TRUE(options) << options.error().message;
    ups =
        std::make_unique<NutUps>(described, *options, *transport::parse_address(described.address),
                                 context.get_executor(), clock);
    return *ups;
  }
  static Script identified_and(const Script& rest) {
    Script out{expect("VER\n"),
               send("Network UPS Tools upsd 2.8.0 - http://www.networkupstools.org/\n")};
    out.insert(out.end(), rest.begin(), rest.end());
    return out;
  }
  static Script answers(const std::string& status, const std::string& charge,
                        const std::string& runtime) {
    return {expect("GET VAR rack ups.status\n"),      send(status + "\n"),
            expect("GET VAR rack battery.charge\n"),  send(charge + "\n"),
            expect("GET VAR rack battery.runtime\n"), send(runtime + "\n")};
  }
  std::unique_ptr<NutUps> ups;
};

struct Unusable {
  const char* name;
  const char* reply;
};
class UnusableRuntime : public UpsLoop, public testing::WithParamInterface<Unusable> {};

// networkupstools/nut issue 983: battery.runtime "-1".
TEST_P(UnusableRuntime, IsMissingBesideAStatusThatCounts) {
  const auto twice =
      answers("VAR rack ups.status \"OB LB\"", "VAR rack battery.charge \"9\"", GetParam().reply);
  auto script = identified_and(twice);
  script.insert(script.end(), twice.begin(), twice.end());
  peer.on_connection(script);
  make();
  for (int i = 0; i < 2; ++i) {
    const auto reading = run(ups->read());
    ASSERT_TRUE(reading) << reading.error().message;
    EXPECT_EQ(*reading->find("rack_on_battery_1"), 1);
    EXPECT_EQ(*reading->find("rack_low_battery_1"), 1) << "the hold before power goes";
    EXPECT_EQ(*reading->find("rack_charge_pct"), 9);
    EXPECT_TRUE(is_missing(*reading->find("rack_runtime_s")));
  }
  EXPECT_TRUE(peer.finished());
}
INSTANTIATE_TEST_SUITE_P(Table, UnusableRuntime,
                         testing::Values(Unusable{"minus_one", "VAR rack battery.runtime \"-1\""},
                                         Unusable{"empty", "VAR rack battery.runtime \"\""},
                                         Unusable{"no_number", "VAR rack battery.runtime \"n/a\""},
                                         Unusable{"not_supported", "ERR VAR-NOT-SUPPORTED"},
                                         Unusable{"stale", "ERR DATA-STALE"},
                                         Unusable{"another_error", "ERR INVALID-ARGUMENT"}),
                         [](const auto& row) { return std::string(row.param.name); });

TEST_F(UpsLoop, ALineThatBreaksBehindTheStatusTakesNothingOfIt) {
  peer.on_connection(
      identified_and({expect("GET VAR rack ups.status\n"), send("VAR rack ups.status \"OB LB\"\n"),
                      expect("GET VAR rack battery.charge\n"), hang_up()}));
  const auto reading = run(make().read());
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_EQ(*reading->find("rack_low_battery_1"), 1);
  EXPECT_TRUE(is_missing(*reading->find("rack_charge_pct")));
  EXPECT_TRUE(is_missing(*reading->find("rack_runtime_s")));
}

TEST_F(UpsLoop, AStatusThatSaysNothingFailsTheReading) {
  peer.on_connection(
      identified_and({expect("GET VAR rack ups.status\n"), send("ERR DATA-STALE\n")}));
  const auto reading = run(make().read());
  ASSERT_FALSE(reading);
  EXPECT_EQ(reading.error().reason, "UPS_STALE");
}

// NUT's upsmon.c, is_ups_critical: OB and LB are not critical while CAL is set.
TEST(NutStatus, ARuntimeCalibrationIsNoLowBattery) {
  for (const char* status : {"OB CAL DISCHRG LB", "CAL OB LB", "OB LB DISCHRG CAL"}) {
    EXPECT_FALSE(AboutToGo().take(*parse_status(status))) << status;
    EXPECT_TRUE(parse_status(status)->on_battery) << status;
  }
  EXPECT_TRUE(AboutToGo().take(*parse_status("OB DISCHRG LB"))) << "the calibration is over";
}

TEST(NutStatus, AForcedShutdownCountsDuringACalibration) {
  AboutToGo about_to_go;
  EXPECT_FALSE(about_to_go.take(*parse_status("OB CAL DISCHRG")));
  EXPECT_TRUE(about_to_go.take(*parse_status("FSD OB CAL DISCHRG LB")));
}

}  // namespace
}  // namespace driftwise::nut_ups
