#include "server/formats/cell_file/cell_file.h"

#include <gtest/gtest.h>

#include "drivers/all_devices.h"

namespace driftwise::formats {
namespace {

const std::string kCell = R"([cell]
name = "linear-axis"
database = "data/cell.db"
listen = "127.0.0.1:0"
target_line = "localhost:50052"
http = "127.0.0.1:0"

[clock]
epoch = 2011-07-22T08:00:00Z
speed = 100
file = "clock.state"

[run]
readings_per_point = 5
max_spread_nm = 4.5

[serving]
refuse_stale = true

[[device]]
id = "axis"
kind = "pi-gcs"
address = "127.0.0.1:50000"
options = { terminator = "lf", poll_ms = 20, echo = false }
  [[device.axis]]
  channel = "q1_mm"
  device_axis = "X"
  min_mm = -4.5
  max_mm = 4.5
  u_scale_nm = 1.5

[[device]]
id = "scanner"
kind = "keithley-2701"
address = "127.0.0.1:1394"
period_s = 5
  [[device.probe]]
  channel = "t01_degC"
  input = 101
  r0_ohm = 1000.12
  part = "instrument"
  place = "interferometer base"
  u_k = 0.002
  [[device.probe]]
  channel = "t05_degC"
  input = 102
  part = "robot"

[[device]]
id = "laser-x"
kind = "interferometer-adapter"
address = "[::1]:50001"
length = "x_mm"
u_length_nm = 2

[[device]]
id = "support"
kind = "watlow-ez-zone"
address = "127.0.0.1:502"
)";

TEST(ParseCellFile, ReadsEverySectionAndKeepsDefaults) {
  const auto cell = parse_cell_file(kCell, "/etc/driftwise/cell.toml", drivers::all_devices());
  ASSERT_TRUE(cell) << cell.error().message;
  EXPECT_EQ(cell->name, "linear-axis");
  EXPECT_EQ(cell->http, "127.0.0.1:0");
  EXPECT_EQ(cell->database, "/etc/driftwise/data/cell.db");
  EXPECT_EQ(cell->clock.file, "/etc/driftwise/clock.state");
  EXPECT_EQ(to_iso8601(cell->clock.epoch), "2011-07-22T08:00:00Z");
  EXPECT_EQ(cell->clock.speed, 100.0);
  EXPECT_EQ(cell->run.readings_per_point, 5);
  EXPECT_EQ(cell->run.max_spread_nm, 4.5);
  EXPECT_EQ(cell->run.max_rereads, RunRules{}.max_rereads);
  EXPECT_TRUE(cell->serving.refuse_stale);
  ASSERT_EQ(cell->devices.size(), 4u);
  EXPECT_EQ(cell->find_axis("q1_mm")->device_axis, "X");
  EXPECT_EQ(cell->find_axis("q1_mm")->max_mm, 4.5);
  EXPECT_EQ(cell->devices[0].options.at("terminator"), "lf");
  EXPECT_EQ(cell->devices[0].options.at("poll_ms"), "20");
  EXPECT_EQ(cell->devices[0].options.at("echo"), "false");
  EXPECT_EQ(cell->devices[1].probes()[0].r0_ohm, 1000.12);
  EXPECT_EQ(cell->devices[1].probes()[1].b_per_degc2, -5.775e-7);  // IEC 60751
  EXPECT_EQ(cell->length_channels()[0].name(), "x_mm");
  EXPECT_EQ(cell->text, kCell);
  EXPECT_EQ(cell->hash.size(), 64u);
}

TEST(ParseCellFile, ReadsADriftThatGoesWithAThermometer) {
  std::string text = kCell;
  text.replace(text.find("u_length_nm = 2"), 15,
               "u_drift_nm_per_k = 50\ndrift_channel = \"t01_degC\"");
  const auto cell = parse_cell_file(text, "cell.toml", drivers::all_devices());
  ASSERT_TRUE(cell) << cell.error().message;
  EXPECT_EQ(cell->devices[2].length()->u_drift_nm_per_k, 50);
  EXPECT_EQ(cell->devices[2].length()->drift_channel.name(), "t01_degC");
}

TEST(ParseCellFile, KeepsAnAbsoluteDatabase) {
  std::string text = kCell;
  text.replace(text.find("data/cell.db"), 12, "/var/lib/cell.db");
  EXPECT_EQ(parse_cell_file(text, "cell.toml", drivers::all_devices())->database,
            "/var/lib/cell.db");
}

TEST(ParseCellFile, GivesAnotherHashToAnotherText) {
  EXPECT_NE(parse_cell_file(kCell, "cell.toml", drivers::all_devices())->hash,
            parse_cell_file(kCell + "\n", "cell.toml", drivers::all_devices())->hash);
}

struct CellFileMistake {
  const char* name;
  const char* from;
  const char* to;
  const char* reason;
  const char* says;
};
class BadCell : public testing::TestWithParam<CellFileMistake> {};
TEST_P(BadCell, IsRefusedWithFileLineFieldFoundAndExpected) {
  std::string text = kCell;
  const auto at = text.find(GetParam().from);
  ASSERT_NE(at, std::string::npos);
  text.replace(at, std::string_view(GetParam().from).size(), GetParam().to);
  const auto cell = parse_cell_file(text, "cell.toml", drivers::all_devices());
  ASSERT_FALSE(cell);
  EXPECT_EQ(cell.error().reason, GetParam().reason) << cell.error().message;
  EXPECT_TRUE(cell.error().message.find(GetParam().says) != std::string::npos)
      << cell.error().message;
}
INSTANTIATE_TEST_SUITE_P(
    Table, BadCell,
    testing::Values(
        CellFileMistake{"Syntax", "name = ", "name ", "TOML_SYNTAX", "cell.toml:2: column"},
        CellFileMistake{"DecimalComma", "min_mm = -4.5", "min_mm = -4,5", "TOML_SYNTAX",
                        "saw ',': decimals have a point, such as -25.0"},
        CellFileMistake{"NoPart", "  part = \"robot\"\n", "", "MISSING_KEY",
                        "part: found nothing, expected this key, one of robot, instrument, air"},
        CellFileMistake{
            "UnknownKey", "max_spread_nm", "max_spred_nm", "UNKNOWN_KEY",
            "cell.toml:15: run: found the unknown key 'max_spred_nm': did you mean max_spread_nm?"},
        CellFileMistake{"UnknownSection", "[serving]", "[searving]", "UNKNOWN_KEY",
                        "found the unknown key 'searving': did you mean serving?"},
        CellFileMistake{"KeyOfAnotherKind", "length = \"x_mm\"", "length = \"x_mm\"\naxis = []",
                        "UNKNOWN_KEY", "device 3: found the unknown key 'axis'"},
        CellFileMistake{"DriftOfNoThermometer", "u_length_nm = 2\n",
                        "u_drift_nm_per_k = 50\ndrift_channel = \"t09_degC\"\n", "BAD_CHANNEL",
                        "cell.toml:55: device 3: drift_channel: found 't09_degC', which no probe"},
        CellFileMistake{"DriftWithNothing", "u_length_nm = 2\n", "u_drift_nm_per_k = 50\n",
                        "MISSING_KEY", "found one of u_drift_nm_per_k and drift_channel"},
        CellFileMistake{"DriftWithALength", "u_length_nm = 2\n",
                        "u_drift_nm_per_k = 50\ndrift_channel = \"x_mm\"\n", "BAD_CHANNEL",
                        "expected a thermometer of the cell"},
        CellFileMistake{"NoName", "name = \"linear-axis\"\n", "", "MISSING_KEY",
                        "cell: name: found nothing"},
        CellFileMistake{"EmptyName", "\"linear-axis\"", "\"\"", "OUT_OF_RANGE",
                        "cell: name: found an empty string"},
        CellFileMistake{
            "NoCell",
            "[cell]\nname = \"linear-axis\"\ndatabase = \"data/cell.db\"\nlisten = "
            "\"127.0.0.1:0\"\ntarget_line = \"localhost:50052\"\nhttp = \"127.0.0.1:0\"\n",
            "", "MISSING_KEY", "cell: found no [cell] section"},
        CellFileMistake{"Type", "max_spread_nm = 4.5", "max_spread_nm = \"4.5\"", "WRONG_TYPE",
                        "cell.toml:15: run: max_spread_nm: found '4.5', expected a number"},
        CellFileMistake{"Fraction", "readings_per_point = 5", "readings_per_point = 5.5",
                        "WRONG_TYPE", "found 5.5, expected a whole number"},
        CellFileMistake{"Range", "readings_per_point = 5", "readings_per_point = 0", "OUT_OF_RANGE",
                        "found 0, expected a whole number from 1 to 1000"},
        CellFileMistake{"Infinite", "max_spread_nm = 4.5", "max_spread_nm = inf", "OUT_OF_RANGE",
                        "expected a finite number above 0"},
        CellFileMistake{"Epoch", "2011-07-22T08:00:00Z", "\"yesterday\"", "BAD_TIME",
                        "cell.toml:9: clock: epoch: found 'yesterday'"},
        CellFileMistake{"LocalEpoch", "2011-07-22T08:00:00Z", "2011-07-22T08:00:00", "BAD_TIME",
                        "expected a time in UTC"},
        CellFileMistake{"Kind", "\"pi-gcs\"", "\"pi-gsc\"", "UNKNOWN_KIND",
                        "device 1: kind: found 'pi-gsc', expected one of pi-gcs, keithley-2701"},
        CellFileMistake{"Address", "\"127.0.0.1:50000\"", "\"127.0.0.1\"", "BAD_ADDRESS",
                        "device 1: address: found '127.0.0.1', expected host:port"},
        CellFileMistake{"Port", "127.0.0.1:50000", "127.0.0.1:70000", "BAD_ADDRESS",
                        "found '127.0.0.1:70000'"},
        CellFileMistake{"TwoIds", "id = \"scanner\"", "id = \"axis\"", "DUPLICATE_ID",
                        "device 2: id: found 'axis'"},
        CellFileMistake{"TwoChannels", "channel = \"t05_degC\"", "channel = \"t01_degC\"",
                        "DUPLICATE_CHANNEL", "device 2, probe 2: channel: found 't01_degC'"},
        CellFileMistake{"TwoInputs", "input = 102", "input = 101", "DUPLICATE_CHANNEL",
                        "device 2, probe 2: input: found input 101"},
        CellFileMistake{"ProbeUnit", "\"t05_degC\"", "\"t05_K\"", "BAD_CHANNEL",
                        "expected a temperature in degC"},
        CellFileMistake{"NoUnit", "\"x_mm\"", "\"x\"", "BAD_CHANNEL",
                        "device 3: length: 'x' is no channel"},
        CellFileMistake{"AxisName", "\"q1_mm\"", "\"x_mm\"", "BAD_CHANNEL",
                        "expected a motor coordinate"},
        CellFileMistake{"Limits", "max_mm = 4.5", "max_mm = -5", "BAD_LIMITS",
                        "expected min_mm below max_mm"},
        CellFileMistake{"ZeroOutsideLimits", "min_mm = -4.5", "min_mm = 1", "BAD_LIMITS",
                        "expected 0 between them"},
        CellFileMistake{"NoLimit", "max_mm = 4.5\n", "", "MISSING_KEY",
                        "device 1, axis 1: max_mm: found nothing"},
        CellFileMistake{"Part", "part = \"robot\"", "part = \"robots\"", "OUT_OF_RANGE",
                        "expected one of robot, instrument, air"},
        CellFileMistake{"ListenToTheWorld", "127.0.0.1:0", "0.0.0.0:50051", "LISTEN_NOT_LOOPBACK",
                        "cell.toml:4: cell: listen: found '0.0.0.0:50051'"},
        CellFileMistake{"LineToTheWorld", "localhost:50052", "127.example.org:50052",
                        "LISTEN_NOT_LOOPBACK", "target_line"},
        CellFileMistake{
            "SpeedWithHardware", "127.0.0.1:502", "192.168.0.7:502", "SPEED_NEEDS_LOOPBACK",
            "cell.toml:10: clock: speed: found 100 with device 'support' at '192.168.0.7:502'"},
        CellFileMistake{"Option", "poll_ms = 20", "poll_ms = [20]", "WRONG_TYPE",
                        "options: poll_ms: found an array"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(ReadCellFile, RefusesAFolderAndNamesTheFileThatMayBeMeant) {
  const auto cell = read_cell_file("/", drivers::all_devices());
  ASSERT_FALSE(cell);
  EXPECT_EQ(cell.error().reason, "NOT_A_FILE");
  EXPECT_EQ(cell.error().message,
            "'/' is a folder, expected the cell file itself, such as '/cell.toml'");
}

TEST(ParseCellFile, RefusesSpeedWithHardwareAsAPrecondition) {
  std::string text = kCell;
  text.replace(text.find("127.0.0.1:502\""), 13, "/dev/ttyUSB0");
  const auto cell = parse_cell_file(text, "cell.toml", drivers::all_devices());
  ASSERT_FALSE(cell);
  EXPECT_EQ(cell.error().code, ErrorCode::failed_precondition);
}

TEST(ReadCellFile, NamesAFileThatIsNotThere) {
  const auto cell = read_cell_file("/nowhere/cell.toml", drivers::all_devices());
  ASSERT_FALSE(cell);
  EXPECT_EQ(cell.error().reason, "NO_FILE");
  EXPECT_NE(cell.error().message.find("/nowhere/cell.toml"), std::string::npos);
}

// A driver's complaints come after the file was read.
TEST(DevicePlace, IsTheLineOfTheDeviceOrOfTheOptionThatADriverNames) {
  const auto cell = parse_cell_file(kCell, "cell.toml", drivers::all_devices());
  ASSERT_TRUE(cell) << cell.error().message;
  EXPECT_EQ(device_place(*cell, "cell.toml", 1, "device 'scanner': input 1: expected 101 .. 599"),
            "cell.toml:32: ");
  EXPECT_EQ(device_place(*cell, "cell.toml", 0, "device 'axis': option poll_ms = 'x', expected"),
            "cell.toml:24: ");
  EXPECT_EQ(device_place({}, "cell.toml", 0, ""), "");
}

}  // namespace
}  // namespace driftwise::formats
