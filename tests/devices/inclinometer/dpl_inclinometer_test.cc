#include "drivers/inclinometer/dpl_inclinometer.h"

#include "drivers/all_devices.h"
#include "server/core/ports/made_device.h"
#include "server/formats/cell_file/cell_file.h"
#include "server/plausibility/limits.h"
#include "tests/unit/drivers/driver_fixture.h"

namespace driftwise {
namespace {

using testing::HasSubstr;
using tests::expect;
using tests::Script;
using tests::send;

class InclinometerLoop : public tests::DriverFixture {
 protected:
  DeviceDescription level(std::map<std::string, std::string> options = {}) {
    auto out = device("level", "meas-dpl");
    out.become<AngleSettings>().angles = {{{"rx", "arcsec"}, 1, 1, 4},
                                          {{"ry", "arcsec"}, 2, -1, 4}};
    out.options = std::move(options);
    return out;
  }
  Result<MadeDevice> make(const DeviceDescription& description) {
    const auto* kind = find_kind(drivers::all_devices(), description.kind);
    return kind->make(description, {context.get_executor(), clock});
  }
  // Streaming at first, as after power on.
  static Script stopped_and(const Script& rest) {
    Script out{send("=+01.1\r\nY=-00.1\r\n"),
               expect("sV"),
               send("X=+01.1\r\nsDPL2 V1.8.0\r\n"),
               send("SN:77\r\n"),
               expect("V"),
               send("DPL2 V1.8.0\r\nSN:77\r\n")};
    out.insert(out.end(), rest.begin(), rest.end());
    return out;
  }
};

TEST_F(InclinometerLoop, StopsTheStreamAndGivesTheMeanOfItsPairs) {
  peer.on_connection(stopped_and({expect("R"), send("X=+01.000\r\nY=-00.007\r\n"), expect("R"),
                                  send("X=+01.002\r\nY=-00."), send("009\r\n")}));
  auto made = make(level({{"readings", "2"}}));
  ASSERT_TRUE(made) << made.error().message;
  const auto reading = run(made->as<Instrument>()->read());
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_NEAR(*reading->find("rx_arcsec"), 1.001 * 3600, 1e-9);
  EXPECT_NEAR(*reading->find("ry_arcsec"), 0.008 * 3600, 1e-9);
  EXPECT_LE(reading->start, reading->end);
  EXPECT_EQ(made->device().health().identity, "DPL2 V1.8.0, SN:77");
  EXPECT_TRUE(peer.finished());
}

TEST_F(InclinometerLoop, RefusesATiltBeyondItsRange) {
  peer.on_connection(stopped_and({expect("R"), send("X=+31.000\r\nY=-00.007\r\n")}));
  auto made = make(level());
  ASSERT_TRUE(made);
  const auto reading = run(made->as<Instrument>()->read());
  ASSERT_FALSE(reading);
  EXPECT_EQ(reading.error().reason, "OUT_OF_RANGE");
  EXPECT_THAT(reading.error().message, HasSubstr("level"));
}

TEST_F(InclinometerLoop, HasNoZeroAndNamesAWrongOption) {
  auto made = make(level());
  ASSERT_TRUE(made);
  EXPECT_EQ(run(made->as<Instrument>()->zero()).error().reason, "NO_ZERO");
  EXPECT_EQ(make(level({{"readings", "0"}})).error().reason, "BAD_OPTION");
}

TEST_F(InclinometerLoop, IsDescribedByTheCellFile) {
  const std::string text =
      "[cell]\nname = \"c\"\ndatabase = \"d\"\n[[device]]\nid = \"level\"\nkind = \"meas-dpl\"\n"
      "address = \"/dev/ttyUSB0\"\nperiod_s = 5\n  [[device.angle]]\n  channel = \"rx_arcsec\"\n"
      "  device_axis = 1\n";
  const auto cell = formats::parse_cell_file(text, "cell.toml", drivers::all_devices());
  ASSERT_TRUE(cell) << cell.error().message;
  EXPECT_EQ(cell->devices[0].role(), DeviceRole::angle);
  EXPECT_EQ(cell->devices[0].channels, (std::vector<Channel>{{"rx", "arcsec"}}));
}

// Not that of an autocollimator, 400 arcsec: a tilt of a degree is what it is for.
TEST_F(InclinometerLoop, ItsAnglesAreJudgedByTheRangeOfItsModel) {
  const auto limit_with = [](const std::string& options) {
    const auto cell = formats::parse_cell_file(
        "[cell]\nname = \"c\"\ndatabase = \"d\"\n[[device]]\nid = \"level\"\nkind = \"meas-dpl\"\n"
        "address = \"/dev/ttyUSB0\"\nperiod_s = 5\n" +
            options + "  [[device.angle]]\n  channel = \"rx_arcsec\"\n  device_axis = 1\n",
        "cell.toml", drivers::all_devices());
    EXPECT_TRUE(cell) << cell.error().message;
    return plausibility::limit_of(*cell, cell->devices[0], "rx_arcsec");
  };
  EXPECT_EQ(limit_with("").max, 30 * 3600.0);
  EXPECT_EQ(limit_with("options = { range_deg = 2 }\n").max, 2 * 3600.0);
  EXPECT_EQ(limit_with("options = { range_deg = 2 }\n").min, -2 * 3600.0);
}

}  // namespace
}  // namespace driftwise
