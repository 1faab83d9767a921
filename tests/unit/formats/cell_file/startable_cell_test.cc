#include "server/formats/cell_file/startable_cell.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "drivers/all_devices.h"
#include "server/core/try.h"
#include "server/formats/cell_file/cell_file.h"

namespace driftwise::formats {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

const std::string kHead = "[cell]\nname = \"small\"\ndatabase = \"cell.db\"\n";

std::string device(const std::string& id, const std::string& kind, const std::string& address) {
  return "[[device]]\nid = \"" + id + "\"\nkind = \"" + kind + "\"\naddress = \"" + address +
         "\"\n";
}

std::string axis(const std::string& channel, const std::string& name) {
  return "[[device.axis]]\nchannel = \"" + channel + "\"\ndevice_axis = \"" + name +
         "\"\nmin_mm = -5\nmax_mm = 5\n";
}

std::string laser(const std::string& id, const std::string& length, const std::string& options,
                  const std::string& address = "10.0.0.2:4000") {
  return device(id, "interferometer-adapter", address) + "length = \"" + length + "\"\n" +
         (options.empty() ? "" : "options = { " + options + " }\n");
}

const std::string kAxis = device("axis", "pi-gcs", "10.0.0.1:5000") + axis("q1_mm", "X");
const std::string kOwnNames = "air_channel = \"air_y_degC\", level_channel = \"level_y_pct\"";
const std::string kLaser = laser("laser-x", "x_mm", "channel = 1");

Result<void> start_of(const std::string& text) {
  DRIFTWISE_TRY(const auto cell, parse_cell_file(text, "cell.toml", drivers::all_devices()));
  return check_startable(cell, "cell.toml");
}

Error refusal_of(const std::string& text) {
  const auto start = start_of(text);
  return start ? Error{ErrorCode::internal, "ACCEPTED", text} : start.error();
}

TEST(StartableCell, HasAControllerAndAnInstrumentOfThePose) {
  EXPECT_TRUE(start_of(kHead + kAxis + kLaser));

  const auto no_motion = refusal_of(kHead + kLaser);
  EXPECT_EQ(no_motion.reason, "NO_CONTROLLER");
  EXPECT_THAT(no_motion.message, StartsWith("cell.toml:4: device: found no motion controller"));
  EXPECT_THAT(no_motion.message, HasSubstr("kind 'pi-gcs'"));

  const auto no_length = refusal_of(kHead + kAxis);
  EXPECT_EQ(no_length.reason, "NO_INSTRUMENT");
  EXPECT_THAT(no_length.message, StartsWith("cell.toml:4: device: found no instrument"));
  EXPECT_THAT(no_length.message, HasSubstr("'interferometer-adapter'"));
}

TEST(StartableCell, NamesARobotForEachOfSeveralControllers) {
  const auto second = device("hexapod", "pi-gcs", "10.0.0.9:5000") + axis("q2_mm", "X");
  const auto refused = refusal_of(kHead + kAxis + second + kLaser);
  EXPECT_EQ(refused.reason, "TWO_CONTROLLERS");
  EXPECT_THAT(refused.message, StartsWith("cell.toml:5: device 1: id: found 'axis'"));
}

TEST(StartableCell, ReadsAnInterferometerAsOneCoordinateOnly) {
  const auto refused = refusal_of(kHead + kAxis + kLaser + laser("laser-y", "y_mm", ""));
  EXPECT_EQ(refused.reason, "DUPLICATE_OUTPUT");
  EXPECT_EQ(refused.message,
            "cell.toml:22: device 3: address: found '10.0.0.2:4000', channel 1, which is "
            "'x_mm' of device 'laser-x' already: 'y_mm' would be the same one, expected an "
            "output of its own");
  EXPECT_TRUE(
      start_of(kHead + kAxis + kLaser + laser("laser-y", "y_mm", "channel = 2, " + kOwnNames)));
  EXPECT_TRUE(
      start_of(kHead + kAxis + kLaser + laser("laser-y", "y_mm", kOwnNames, "10.0.0.3:4000")));
}

// A person carries the laser from one beam to the other between the two set-ups.
TEST(StartableCell, MayPlaceOneInstrumentElsewhereInAnotherSetup) {
  const auto setup = [](const std::string& length, const std::string& id) {
    return "[[setup]]\nname = \"" + length + "\"\n[[setup.coordinate]]\nchannel = \"" + length +
           "\"\ndevice = \"" + id + "\"\n";
  };
  const auto cell = kHead + kAxis + kLaser + laser("laser-y", "y_mm", "");
  EXPECT_TRUE(start_of(cell + setup("x_mm", "laser-x") + setup("y_mm", "laser-y")));
  EXPECT_EQ(refusal_of(cell + setup("x_mm", "laser-x") +
                       "[[setup.coordinate]]\nchannel = \"y_mm\"\ndevice = \"laser-y\"\n")
                .reason,
            "DUPLICATE_OUTPUT");
}

TEST(StartableCell, MovesEachAxisOfAControllerByOneCoordinate) {
  const auto refused = refusal_of(kHead + kAxis + axis("q2_mm", "X") + kLaser);
  EXPECT_EQ(refused.reason, "DUPLICATE_OUTPUT");
  EXPECT_THAT(refused.message, StartsWith("cell.toml:15: device 1, axis 2: device_axis: found X at "
                                          "'10.0.0.1:5000', which is 'q1_mm' already: 'q2_mm'"));
  EXPECT_TRUE(start_of(kHead + kAxis + axis("q2_mm", "Y") + kLaser));
}

TEST(StartableCell, ReadsEachInputOfAScannerOnceAndInItsRange) {
  const auto probe = [](const std::string& channel, const std::string& input) {
    return "[[device.probe]]\nchannel = \"" + channel + "\"\ninput = " + input +
           "\npart = \"robot\"\n";
  };
  const auto scanner = [&](const std::string& id, const std::string& channel) {
    return device(id, "keithley-2701", "10.0.0.4:1394") + probe(channel, "101");
  };
  const auto twice =
      refusal_of(kHead + kAxis + kLaser + scanner("a", "t01_degC") + scanner("b", "t02_degC"));
  EXPECT_EQ(twice.reason, "DUPLICATE_OUTPUT");
  EXPECT_THAT(twice.message, HasSubstr("device 4, probe 1: input: found 101 at '10.0.0.4:1394', "
                                       "which is 't01_degC' of device 'a' already"));

  const auto range =
      refusal_of(kHead + kAxis + kLaser + device("a", "keithley-2701", "10.0.0.4:1394") +
                 probe("t01_degC", "1"));
  EXPECT_EQ(range.reason, "OUT_OF_RANGE");
  EXPECT_THAT(range.message,
              StartsWith("cell.toml:25: device 3, probe 1: input: found 1, expected"));
}

TEST(StartableCell, MeasuresThePoseOfEachLinearAxis) {
  const auto geometry = [](const std::string& pose) {
    return "[kinematics]\nkind = \"linear-axis\"\n[[kinematics.axis]]\nmotor = \"q1_mm\"\npose = "
           "\"" +
           pose + "\"\n";
  };
  EXPECT_TRUE(start_of(kHead + kAxis + kLaser + geometry("x_mm")));
  const auto refused = refusal_of(kHead + kAxis + kLaser + geometry("y_mm"));
  EXPECT_EQ(refused.reason, "NOT_MEASURED");
  EXPECT_THAT(refused.message,
              StartsWith("cell.toml:23: kinematics, axis 1: pose: found 'y_mm', which no device of "
                         "this cell measures, expected one of x_mm"));
}

// Without the motor's readback nothing is compared with the geometry, and nobody is told.
TEST(StartableCell, MovesEveryMotorOfItsGeometry) {
  const std::string head = "[kinematics]\nkind = \"linear-axis\"\n[[kinematics.axis]]\nmotor = \"";
  const auto refused = refusal_of(kHead + kAxis + kLaser + head + "q2_mm\"\npose = \"x_mm\"\n");
  EXPECT_EQ(refused.reason, "UNKNOWN_AXIS");
  EXPECT_THAT(refused.message,
              StartsWith("cell.toml:22: kinematics, axis 1: motor: found 'q2_mm', which controller "
                         "'axis' does not move, expected one of q1_mm"));

  std::string delta = "[kinematics]\nkind = \"delta-vertical\"\n";
  for (const char* branch :
       {"q1_mm\"\nazimuth_deg = 0", "q2_mm\"\nazimuth_deg = 120", "q7_mm\"\nazimuth_deg = 240"})
    delta += "[[kinematics.branch]]\nmotor = \"" + std::string(branch) +
             "\nradius_mm = 100\nlength_mm = 200\n";
  const auto branch =
      refusal_of(kHead + kAxis + axis("q2_mm", "Y") + axis("q3_mm", "Z") + kLaser + delta);
  EXPECT_EQ(branch.reason, "UNKNOWN_AXIS");
  EXPECT_THAT(branch.message, HasSubstr("kinematics, branch 3: motor: found 'q7_mm', which "
                                        "controller 'axis' does not move, expected one of q1_mm, "
                                        "q2_mm, q3_mm"));
}

// An arm beside the cell: its angles are no axes, and its geometry serves targets.
TEST(StartableCell, MayDescribeAnArmWhoseJointsNoControllerMoves) {
  std::string arm = "[kinematics]\nkind = \"serial-arm\"\n";
  for (const char* joint : {"q1", "q2", "q3", "q4", "q5", "q6"})
    arm += "[[kinematics.link]]\nmotor = \"" + std::string(joint) +
           "_rad\"\nd_mm = 100\na_mm = 200\nalpha_deg = 90\n";
  const auto start = start_of(kHead + kAxis + kLaser + arm);
  EXPECT_TRUE(start) << start.error().message;
}

TEST(StartableCell, MovesTheMotorsOfARobotByItsOwnController) {
  const auto cell = [](const std::string& motor) {
    return kHead + device("one", "pi-gcs", "10.0.0.1:5000") + axis("ma.q1_mm", "X") +
           device("two", "pi-gcs", "10.0.0.9:5000") + axis("mb.q2_mm", "X") +
           laser("laser-x", "ma.x_mm", "channel = 1") +
           "[[robot]]\nid = \"ma\"\ncontroller = \"one\"\n[robot.kinematics]\n"
           "kind = \"linear-axis\"\n[[robot.kinematics.axis]]\nmotor = \"" +
           motor + "\"\npose = \"x_mm\"\n[[robot]]\nid = \"mb\"\ncontroller = \"two\"\n";
  };
  const auto start = start_of(cell("q1_mm"));
  EXPECT_TRUE(start) << start.error().message;
  const auto refused = refusal_of(cell("q2_mm"));
  EXPECT_EQ(refused.reason, "UNKNOWN_AXIS");
  EXPECT_THAT(refused.message,
              HasSubstr("robot 1, kinematics, axis 1: motor: found 'q2_mm', which controller 'one' "
                        "does not move for robot 'ma', expected one of q1_mm"));
}

// A motor's current names the coordinate of the motor by the word that a controller has for its
// tables of axes.
TEST(StartableCell, TakesAnAxisThatIsNamedForNoListOfAxes) {
  const std::string force = device("motor-1", "keithley-2701", "10.0.0.3:1394") +
                            "measures = \"motor-force\"\naxis = \"q1_mm\"\nfriction_n = 0.4\n"
                            "u_friction_n = 0.02\ntravel_mm = 0.02\n[[device.sensor]]\n"
                            "channel = \"motor_force_N\"\ninput = 202\nslope = 4\n"
                            "slope_unit = \"N/V\"\nmin_v = -9\nmax_v = 9\nu = 0.01\n";
  const auto start = start_of(kHead + kAxis + kLaser + force);
  EXPECT_TRUE(start) << start.error().message;
}

// Points stored the mean of two lasers' air, and a hold on the light was met with a dark beam.
TEST(StartableCell, GivesEachChannelByOneDeviceOptionsIncluded) {
  const auto shared = refusal_of(kHead + kAxis + kLaser + laser("laser-y", "y_mm", "channel = 2"));
  EXPECT_EQ(shared.reason, "DUPLICATE_CHANNEL");
  EXPECT_THAT(shared.message, HasSubstr("device 3: options: found 'air_degC', which device "
                                        "'laser-x' gives already"));
  const auto support = device("support", "watlow-ez-zone", "10.0.0.4:502");
  const auto text =
      kHead + kAxis + support + laser("laser-x", "x_mm", "air_channel = \"support_degC\"");
  EXPECT_EQ(refusal_of(text).reason, "DUPLICATE_CHANNEL");
  EXPECT_TRUE(parse_cell_file(text, "cell.toml", drivers::all_devices()))
      << "the cell files of old records stay readable";
}

TEST(StartableCell, HasOneKindOfDeviceAtAnAddress) {
  const auto refused = refusal_of(kHead + kAxis + laser("laser-x", "x_mm", "", "10.0.0.1:5000"));
  EXPECT_THAT(refused.message, HasSubstr("address: found '10.0.0.1:5000', which is the address of "
                                         "device 'axis', a 'pi-gcs'"));
  EXPECT_THAT(refused.message, HasSubstr("'laser-x'"));
}

TEST(StartableCell, HasOneKindOfDeviceAtASerialLineUnderWhateverName) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "startable_cell_lines";
  std::filesystem::create_directories(folder);
  const auto line = folder / "ttyUSB0", by_id = folder / "by-id";
  std::ofstream{line};
  std::filesystem::remove(by_id);
  std::filesystem::create_symlink(line, by_id);
  const auto at = [](const std::filesystem::path& axis_line) {
    return kHead + device("axis", "pi-gcs", axis_line.string()) + axis("q1_mm", "X");
  };
  for (const auto& name : {line, by_id})
    EXPECT_THAT(refusal_of(at(line) + laser("laser-x", "x_mm", "", name.string())).message,
                HasSubstr("which is the address of device 'axis', a 'pi-gcs'"));
  EXPECT_TRUE(start_of(at(line) + laser("laser-x", "x_mm", "", folder / "ttyUSB1")));
}

TEST(StartableCell, ComparesItsDoorsWithItsDevicesAndItsRecordWithItself) {
  const auto head = [](const std::string& more) {
    return "[cell]\nname = \"small\"\ndatabase = \"cell.db\"\n" + more;
  };
  const std::string twice = "listen = \"127.0.0.1:50051\"\ntarget_line = \"localhost:50051\"\n";
  EXPECT_THAT(refusal_of(head(twice) + kAxis + kLaser).message,
              HasSubstr("target_line: found 'localhost:50051', which is the address of listen"));
  const auto local = laser("laser-x", "x_mm", "", "127.0.0.1:4000");
  EXPECT_THAT(refusal_of(head("listen = \"127.0.0.1:4000\"\n") + kAxis + local).message,
              HasSubstr("listen: found '127.0.0.1:4000', which is the address of device "
                        "'laser-x'"));
  EXPECT_TRUE(start_of(head("listen = \"127.0.0.1:0\"\nhttp = \"127.0.0.1:0\"\n") + kAxis + local))
      << "port 0 is any free one";
  EXPECT_THAT(
      refusal_of("[cell]\nname = \"small\"\ndatabase = \"cell.toml\"\n" + kAxis + kLaser).message,
      HasSubstr("which is this cell file"));
  for (const std::string address : {"127.0.0.1 :21002", "no such host:1"})
    EXPECT_EQ(refusal_of(kHead + kAxis + laser("laser-x", "x_mm", "", address)).reason,
              "BAD_ADDRESS");
}

}  // namespace
}  // namespace driftwise::formats
