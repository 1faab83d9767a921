// [[setup]]: what is read, and what is refused, naming the line.

#include <gmock/gmock.h>

#include <map>
#include <string>

#include "drivers/all_devices.h"
#include "server/formats/cell_file/cell_file.h"
#include "server/formats/cell_file/cell_file_correction.h"
#include "server/formats/cell_file/cell_file_difference.h"

namespace driftwise::formats {
namespace {

using testing::HasSubstr;

constexpr const char* kSetupCell =
    "[cell]\nname = \"small\"\ndatabase = \"cell.db\"\n"
    "[[device]]\nid = \"axis\"\nkind = \"pi-gcs\"\naddress = \"127.0.0.1:1\"\n"
    "  [[device.axis]]\n  channel = \"q1_mm\"\n  device_axis = \"X\"\n  min_mm = -5\n  max_mm = 5\n"
    "[[device]]\nid = \"laser-x\"\nkind = \"interferometer-adapter\"\n"
    "address = \"127.0.0.1:3\"\nperiod_s = 2\nlength = \"x_mm\"\n";

Result<CellDescription> cell_with(const std::string& setup) {
  return parse_cell_file(std::string(kSetupCell) + setup, "cell.toml", drivers::all_devices());
}

std::string coordinate(const std::string& keys) {
  return "[[setup]]\nname = \"lengths\"\n  [[setup.coordinate]]\n" + keys;
}

TEST(CellFileSetups, SayWhichInstrumentGivesWhichCoordinate) {
  const auto cell = cell_with(coordinate(
      "channel = \"x_mm\"\ndevice = \"laser-x\"\nscale = 1.0002\noffset = -0.5\nmin = -4\n"));
  ASSERT_TRUE(cell) << cell.error().message;
  ASSERT_EQ(cell->setups.size(), 1u);
  const auto& x = cell->setups[0].coordinates.at(0);
  EXPECT_EQ(x.channel, (Channel{"x", "mm"}));
  EXPECT_EQ(x.device, "laser-x");
  EXPECT_EQ(x.scale, 1.0002);
  EXPECT_EQ(x.offset, -0.5);
  EXPECT_EQ(x.min, -4);
  EXPECT_FALSE(x.max);
  EXPECT_TRUE(x.may_be_missing());
}

TEST(CellFileSetups, MayMoveTheZeroWithinTheRange) {
  for (const char* range : {"offset = 5\nmin = 1\n", "offset = -2\nmin = -2\nmax = 3\n"})
    EXPECT_TRUE(
        cell_with(coordinate("channel = \"x_mm\"\ndevice = \"laser-x\"\n" + std::string(range))))
        << range;
}

// An inclinometer says how far it is from the plumb line: at the zero it shows what it shows.
TEST(CellFileSetups, LetARotationCountFromElsewhere) {
  const auto cell = cell_with(
      "[[device]]\nid = \"level\"\nkind = \"meas-dpl\"\naddress = \"127.0.0.1:5\"\n"
      "  [[device.angle]]\n  channel = \"rx_arcsec\"\n  device_axis = 1\n" +
      coordinate("channel = \"rx_arcsec\"\ndevice = \"level\"\nmin = 100\nmax = 900\n"));
  EXPECT_TRUE(cell) << cell.error().message;
}

// A probe that gives the interferometer's coordinate as well.
constexpr const char* kTouch =
    "[[device]]\nid = \"touch\"\nkind = \"heidenhain-nd28x\"\naddress = \"127.0.0.1:4\"\n"
    "length = \"x_mm\"\n";

std::string setup_of(const std::string& name, const std::string& device) {
  return "[[setup]]\nname = \"" + name + "\"\n  [[setup.coordinate]]\n  channel = \"x_mm\"\n" +
         "  device = \"" + device + "\"\n";
}

TEST(CellFileSetups, LetTwoInstrumentsGiveOneCoordinate) {
  const auto cell = cell_with(kTouch + setup_of("light", "laser-x") + setup_of("tip", "touch"));
  ASSERT_TRUE(cell) << cell.error().message;
  EXPECT_EQ(cell->length_channels(), (std::vector<Channel>{{"x", "mm"}}));
}

TEST(CellFileSetups, AreNeededWhereTwoInstrumentsGiveOneCoordinate) {
  const auto cell = cell_with(kTouch);
  ASSERT_FALSE(cell);
  EXPECT_EQ(cell.error().reason, "DUPLICATE_CHANNEL");
  EXPECT_THAT(cell.error().message, HasSubstr("only a cell with [[setup]]"));
}

TEST(CellFileSetups, NameNoTwoInstrumentsOfOneCoordinate) {
  const std::string angles =
      "[[device]]\nid = \"level\"\nkind = \"meas-dpl\"\naddress = \"127.0.0.1:5\"\n"
      "  [[device.angle]]\n  channel = \"rx_arcsec\"\n  device_axis = 1\n"
      "  [[device.angle]]\n  channel = \"ry_arcsec\"\n  device_axis = 2\n"
      "[[device]]\nid = \"fine\"\nkind = \"newport-lds1000\"\naddress = \"127.0.0.1:6\"\n"
      "  [[device.angle]]\n  channel = \"rx_arcsec\"\n  device_axis = 1\n";
  const auto cell = cell_with(
      angles + coordinate("channel = \"rx_arcsec\"\ndevice = \"fine\"\n"
                          "  [[setup.coordinate]]\nchannel = \"ry_arcsec\"\ndevice = \"level\"\n"));
  ASSERT_FALSE(cell);
  EXPECT_EQ(cell.error().reason, "BAD_SETUP");
  EXPECT_THAT(cell.error().message,
              HasSubstr("'rx_arcsec' of 'fine', and 'level' gives it as well"));
}

// Two autocollimators that both see rz.
constexpr const char* kTwoCollimators =
    "[[device]]\nid = \"c1\"\nkind = \"newport-lds1000\"\naddress = \"127.0.0.1:6\"\n"
    "  [[device.angle]]\n  channel = \"ry_arcsec\"\n  device_axis = 1\n"
    "  [[device.angle]]\n  channel = \"rz_arcsec\"\n  device_axis = 2\n"
    "[[device]]\nid = \"c2\"\nkind = \"newport-lds1000\"\naddress = \"127.0.0.1:7\"\n"
    "  [[device.angle]]\n  channel = \"rx_arcsec\"\n  device_axis = 1\n"
    "  [[device.angle]]\n  channel = \"rz_arcsec\"\n  device_axis = 2\n";

std::string confirmed_setup(const std::string& confirmation) {
  std::string text = std::string(kTwoCollimators) + "[[setup]]\nname = \"tilts\"\n";
  for (const auto& [channel, device] : std::map<std::string, std::string>{
           {"rx_arcsec", "c2"}, {"ry_arcsec", "c1"}, {"rz_arcsec", "c1"}})
    text +=
        "  [[setup.coordinate]]\n  channel = \"" + channel + "\"\n  device = \"" + device + "\"\n";
  return text + confirmation;
}

TEST(CellFileSetups, LetASecondInstrumentConfirmARotation) {
  const auto cell =
      cell_with(confirmed_setup("  [[setup.confirmation]]\n  channel = \"rz_arcsec\"\n"
                                "  device = \"c2\"\n  scale = -1\n  limit = 0.4\n"));
  ASSERT_TRUE(cell) << cell.error().message;
  const auto& one = cell->setups[0].confirmations.at(0);
  EXPECT_EQ(one.device, "c2");
  EXPECT_EQ(one.scale, -1);
  EXPECT_EQ(one.limit, 0.4);
  EXPECT_EQ(one.confirmed().name(), "rz_confirmed_arcsec");
}

TEST(CellFileSetups, ChangeWithTheLimitOfAConfirmation) {
  const auto with_limit = [](const std::string& limit) {
    return *cell_with(
        confirmed_setup("  [[setup.confirmation]]\n  channel = \"rz_arcsec\"\n"
                        "  device = \"c2\"\n  limit = " +
                        limit + "\n"));
  };
  const auto changes = cell_file_difference(with_limit("0.4").text, with_limit("0.5"));
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].key, "confirmation rz_arcsec");
}

struct BadSetup {
  const char* name;
  std::string setup;
  const char* reason;
  const char* message;
};
class BadSetups : public testing::TestWithParam<BadSetup> {};
TEST_P(BadSetups, AreRefused) {
  const auto cell = cell_with(GetParam().setup);
  ASSERT_FALSE(cell);
  EXPECT_EQ(cell.error().reason, GetParam().reason);
  EXPECT_THAT(cell.error().message, HasSubstr(GetParam().message));
}
INSTANTIATE_TEST_SUITE_P(
    Table, BadSetups,
    testing::Values(
        BadSetup{"unconfirmed", confirmed_setup(""), "BAD_SETUP",
                 "or a [[setup.confirmation]] of it by the second one"},
        BadSetup{"confirms_itself",
                 confirmed_setup("  [[setup.confirmation]]\n  channel = \"ry_arcsec\"\n"
                                 "  device = \"c1\"\n  limit = 0.4\n"),
                 "BAD_SETUP", "expected a second instrument"},
        BadSetup{"confirms_nothing",
                 kTwoCollimators + coordinate("channel = \"ry_arcsec\"\ndevice = \"c1\"\n") +
                     "  [[setup.confirmation]]\n  channel = \"rx_arcsec\"\n"
                     "  device = \"c2\"\n  limit = 0.4\n",
                 "BAD_SETUP", "expected a coordinate that this set-up measures"},
        BadSetup{"confirms_a_length",
                 kTouch + coordinate("channel = \"x_mm\"\ndevice = \"laser-x\"\n") +
                     "  [[setup.confirmation]]\n  channel = \"x_mm\"\n"
                     "  device = \"touch\"\n  limit = 0.4\n",
                 "BAD_SETUP", "expected a rotation"},
        BadSetup{"no_limit",
                 confirmed_setup("  [[setup.confirmation]]\n  channel = \"rz_arcsec\"\n"
                                 "  device = \"c2\"\n"),
                 "MISSING_KEY", "limit"},
        BadSetup{"nothing", "[[setup]]\nname = \"lengths\"\n", "BAD_SETUP",
                 "found no [[setup.coordinate]]"},
        BadSetup{
            "device", coordinate("channel = \"x_mm\"\ndevice = \"axis\"\n"), "BAD_SETUP",
            "found 'axis', expected an interferometer or autocollimator of this cell: laser-x"},
        BadSetup{"unmeasured", coordinate("channel = \"y_mm\"\ndevice = \"laser-x\"\n"),
                 "BAD_SETUP", "found 'y_mm', expected a coordinate of 'laser-x': x_mm"},
        BadSetup{"scale", coordinate("channel = \"x_mm\"\ndevice = \"laser-x\"\nscale = 0\n"),
                 "BAD_SETUP", "found 0, expected another number"},
        BadSetup{"range",
                 coordinate("channel = \"x_mm\"\ndevice = \"laser-x\"\nmin = 1\nmax = -1\n"),
                 "BAD_SETUP", "expected min to be the lower one"},
        BadSetup{"zero_below_the_range",
                 coordinate("channel = \"x_mm\"\ndevice = \"laser-x\"\nmin = 1\nmax = 3\n"),
                 "BAD_SETUP", "min: found 1 mm, which leaves out the zero of 'x_mm' (0 mm after"},
        BadSetup{"zero_above_the_range",
                 coordinate("channel = \"x_mm\"\ndevice = \"laser-x\"\noffset = 5\nmax = 4.9\n"),
                 "BAD_SETUP", "max: found 4.9 mm, which leaves out the zero of 'x_mm' (5 mm after"},
        BadSetup{"twice",
                 coordinate("channel = \"x_mm\"\ndevice = \"laser-x\"\n  [[setup.coordinate]]\n"
                            "channel = \"x_mm\"\ndevice = \"laser-x\"\n"),
                 "DUPLICATE_CHANNEL", "another coordinate of this set-up has already"},
        BadSetup{"name",
                 coordinate("channel = \"x_mm\"\ndevice = \"laser-x\"\n") +
                     coordinate("channel = \"x_mm\"\ndevice = \"laser-x\"\n"),
                 "DUPLICATE_ID", "another [[setup]] has already"},
        BadSetup{"key", coordinate("channel = \"x_mm\"\ndevice = \"laser-x\"\nrange = 3\n"),
                 "UNKNOWN_KEY", "range"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(CellFileSetups, ThatChangeAreADifference) {
  const auto before = cell_with(coordinate("channel = \"x_mm\"\ndevice = \"laser-x\"\n"));
  const auto after =
      cell_with(coordinate("channel = \"x_mm\"\ndevice = \"laser-x\"\nscale = 1.001\n"));
  ASSERT_TRUE(before && after);
  const auto changes = cell_file_difference(before->text, *after);
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].place, "setup lengths");
}

TEST(CorrectionFile, StandsAloneForOfflineWork) {
  const auto correction = parse_correction_file(
      "[correction]\ncosine = true\n[[correction.beam]]\nlength = \"z_mm\"\noffset_mm = [1, 2, "
      "3]\n",
      "beams.toml");
  ASSERT_TRUE(correction) << correction.error().message;
  EXPECT_TRUE(correction->cosine);
  EXPECT_EQ(correction->beams.at(0).offset_mm[1], 2);
  EXPECT_EQ(parse_correction_file("[run]\n", "beams.toml").error().reason, "MISSING_KEY");
  EXPECT_EQ(parse_correction_file("[correction\n", "beams.toml").error().reason, "TOML_SYNTAX");
  EXPECT_THAT(parse_correction_file("[[correction.beam]]\nlength = \"t05_degC\"\n", "beams.toml")
                  .error()
                  .message,
              HasSubstr("beams.toml:"));
}

}  // namespace
}  // namespace driftwise::formats
