#include "drivers/touch_probe/nd28x_probe.h"

#include "drivers/all_devices.h"
#include "server/core/ports/made_device.h"
#include "server/formats/cell_file/cell_file.h"
#include "tests/unit/drivers/driver_fixture.h"

namespace driftwise {
namespace {

using testing::HasSubstr;
using tests::expect;
using tests::Script;
using tests::send;

class TouchProbeLoop : public tests::DriverFixture {
 protected:
  DeviceDescription touch(std::map<std::string, std::string> options = {}) {
    auto out = device("touch", "heidenhain-nd28x");
    out.become<LengthSettings>().channel = {"z", "mm"};
    options.try_emplace("readings", "1");
    out.options = std::move(options);
    return out;
  }
  Result<MadeDevice> make(const DeviceDescription& description) {
    const auto* kind = find_kind(drivers::all_devices(), description.kind);
    return kind->make(description, {context.get_executor(), clock});
  }
  static Script known_and(const Script& rest) {
    Script out{expect("\x1b"
                      "A0000\r"),
               send("\x02ND 287    \r\n349797-05 \r\n"), send("V1.02     \r\n")};
    out.insert(out.end(), rest.begin(), rest.end());
    return out;
  }
};

TEST_F(TouchProbeLoop, GivesTheMeanOfItsValuesAndTheirSpread) {
  peer.on_connection(known_and({expect("\x02"), send("+    1.00000 \r\n"), expect("\x02"),
                                send("+    1.000"), send("20 \r\n")}));
  auto made = make(touch({{"readings", "2"}}));
  ASSERT_TRUE(made) << made.error().message;
  const auto reading = run(made->as<Instrument>()->read());
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_NEAR(*reading->find("z_mm"), 1.0001, 1e-12);
  EXPECT_NEAR(*reading->find("z_std_nm"), 200 / std::sqrt(2.0), 1e-6);
  EXPECT_EQ(made->device().health().identity, "ND 287, 349797-05, V1.02");
  EXPECT_TRUE(peer.finished());
}

TEST_F(TouchProbeLoop, CountsFromItsZeroInItsDirection) {
  peer.on_connection(known_and(
      {expect("\x02"), send("+    1.00000 \r\n"), expect("\x02"), send("+    0.99000 \r\n")}));
  auto made = make(touch({{"direction", "down"}}));
  ASSERT_TRUE(made);
  ASSERT_TRUE(run(made->as<Instrument>()->zero()));
  const auto reading = run(made->as<Instrument>()->read());
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_NEAR(*reading->find("z_mm"), 0.01, 1e-12);
}

// A read-out that lost its mains counts from where the tip was then, and looks as before.
TEST_F(TouchProbeLoop, LosesItsZeroOverABrokenLineUntilItIsZeroedAgain) {
  peer.on_connection(known_and({expect("\x02"), send("+    1.00000 \r\n")}));
  peer.on_connection(known_and(
      {expect("\x02"), send("+    0.25000 \r\n"), expect("\x02"), send("+    0.50000 \r\n")}));
  auto made = make(touch());
  ASSERT_TRUE(made);
  auto& probe = *made->as<Instrument>();
  ASSERT_TRUE(run(probe.zero()));
  made->device().close();
  const auto lost = run(probe.read());
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().reason, "BEAM_LOST") << "a run opens a new datum";
  EXPECT_THAT(lost.error().message, HasSubstr("keeps_value"));
  EXPECT_FALSE(probe.knows_its_zero());
  ASSERT_TRUE(run(probe.zero()));
  EXPECT_TRUE(probe.knows_its_zero());
  EXPECT_NEAR(*run(probe.read())->find("z_mm"), 0.25, 1e-12);
}

TEST_F(TouchProbeLoop, LosesItsZeroWithAnAnswerThatDidNotCome) {
  peer.on_connection(known_and({expect("\x02"), send("+    1.00000 \r\n"), expect("\x02")}));
  peer.on_connection(known_and({}));
  auto made = make(touch());
  ASSERT_TRUE(made);
  auto& probe = *made->as<Instrument>();
  ASSERT_TRUE(run(probe.zero()));
  EXPECT_EQ(run(probe.read()).error().reason, "TIMEOUT");
  EXPECT_EQ(run(probe.read()).error().reason, "BEAM_LOST");
}

TEST_F(TouchProbeLoop, KeepsItsZeroOverABrokenLineWhereItsValueIsDeclaredAbsolute) {
  peer.on_connection(known_and({expect("\x02"), send("+    1.00000 \r\n")}));
  peer.on_connection(known_and({expect("\x02"), send("+    1.25000 \r\n")}));
  auto made = make(touch({{"keeps_value", "on"}}));
  ASSERT_TRUE(made);
  ASSERT_TRUE(run(made->as<Instrument>()->zero()));
  made->device().close();
  const auto reading = run(made->as<Instrument>()->read());
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_NEAR(*reading->find("z_mm"), 0.25, 1e-12);
}

TEST_F(TouchProbeLoop, KnowsNoZeroUntilItIsZeroed) {
  peer.on_connection(known_and(
      {expect("\x02"), send("-    5.50000 \r\n"), expect("\x02"), send("+    1.00000 \r\n")}));
  auto made = make(touch({{"contact_min_mm", "-5"}, {"contact_max_mm", "5"}}));
  ASSERT_TRUE(made);
  auto& probe = *made->as<Instrument>();
  EXPECT_FALSE(probe.knows_its_zero()) << "the one of before went with the daemon";
  EXPECT_FALSE(run(probe.zero()));
  EXPECT_FALSE(probe.knows_its_zero()) << "without contact";
  EXPECT_TRUE(run(probe.zero()));
  EXPECT_TRUE(probe.knows_its_zero());
}

TEST_F(TouchProbeLoop, HasNoLengthWithoutContactAndNothingToZero) {
  peer.on_connection(known_and(
      {expect("\x02"), send("-    5.50000 \r\n"), expect("\x02"), send("-    5.50000 \r\n")}));
  auto made = make(touch({{"contact_min_mm", "-5"}, {"contact_max_mm", "5"}}));
  ASSERT_TRUE(made);
  const auto reading = run(made->as<Instrument>()->read());
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_TRUE(is_missing(*reading->find("z_mm")));
  const auto zeroed = run(made->as<Instrument>()->zero());
  ASSERT_FALSE(zeroed);
  EXPECT_EQ(zeroed.error().reason, "OUT_OF_RANGE");
  EXPECT_THAT(zeroed.error().message, HasSubstr("bring the tip into contact"));
}

TEST_F(TouchProbeLoop, AsksNoIdentityOfAReadOutThatHasNone) {
  peer.on_connection({expect("\x02"), send("+    1.00000 \r\n")});
  auto made = make(touch({{"identity", "off"}}));
  ASSERT_TRUE(made);
  EXPECT_TRUE(run(made->as<Instrument>()->read()));
}

TEST_F(TouchProbeLoop, DoesNotTakeTheLateAnswerOfTheQuestionBefore) {
  peer.on_connection({expect("\x02")});
  peer.on_connection({send("+    1.0"), send("0000 \r\n"), expect("\x02"),
                      send("+    2.00000 \r\n"), expect("\x02"), send("+    3.00000 \r\n")});
  auto made = make(touch({{"identity", "off"}}));
  ASSERT_TRUE(made);
  auto& probe = *made->as<Instrument>();
  const auto late = run(probe.read());
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().reason, "TIMEOUT");
  for (const double expected_mm : {2.0, 3.0}) {
    const auto reading = run(probe.read());
    ASSERT_TRUE(reading) << reading.error().message;
    EXPECT_NEAR(*reading->find("z_mm"), expected_mm, 1e-12);
  }
}

TEST_F(TouchProbeLoop, BacksOffFromAnotherDevice) {
  auto made = make(touch());
  ASSERT_TRUE(made);
  int asked = 0;
  for (const auto begun = std::chrono::steady_clock::now();
       std::chrono::steady_clock::now() - begun < std::chrono::seconds(2); ++asked) {
    peer.on_connection({expect("\x1b"
                               "A0000\r"),
                        send("\x02MODEL 2701\r\nx\r\n"), send("y\r\n")});
    const auto reading = run(made->as<Instrument>()->read());
    ASSERT_FALSE(reading);
    EXPECT_EQ(reading.error().reason, "WRONG_DEVICE") << "also while it is backed off from";
  }
  EXPECT_GT(asked, peer.connections()) << "the waits double beyond the time-out";
  EXPECT_LE(peer.connections(), 8) << "0, 50, 100, 200, 400 ms at least between them";
}

TEST_F(TouchProbeLoop, SaysWhatTheReadOutShowsInThePlaceOfAValue) {
  peer.on_connection(known_and({expect("\x02"), send("SIGNAL X\r\n")}));
  auto made = make(touch());
  ASSERT_TRUE(made);
  const auto reading = run(made->as<Instrument>()->read());
  ASSERT_FALSE(reading);
  EXPECT_EQ(reading.error().reason, "INPUT_ERROR");
  EXPECT_THAT(reading.error().message, HasSubstr("touch"));
}

TEST_F(TouchProbeLoop, NamesAWrongOption) {
  EXPECT_EQ(make(touch({{"readings", "0"}})).error().reason, "BAD_OPTION");
  EXPECT_EQ(make(touch({{"contact_min_mm", "5"}, {"contact_max_mm", "-5"}})).error().reason,
            "BAD_OPTION");
}

TEST_F(TouchProbeLoop, IsDescribedByTheCellFile) {
  const std::string text =
      "[cell]\nname = \"c\"\ndatabase = \"d\"\n[[device]]\nid = \"touch\"\n"
      "kind = \"heidenhain-nd28x\"\naddress = \"/dev/ttyUSB0\"\nlength = \"z_mm\"\n"
      "u_length_nm = 600\n";
  const auto cell = formats::parse_cell_file(text, "cell.toml", drivers::all_devices());
  ASSERT_TRUE(cell) << cell.error().message;
  EXPECT_EQ(cell->devices[0].role(), DeviceRole::length);
  EXPECT_EQ(cell->devices[0].channels.front(), (Channel{"z", "mm"}));
}

}  // namespace
}  // namespace driftwise
