#pragma once
// Cells with sensors whose output is a voltage, made of shipped ones: pieces of their plant and
// cell files.

#include <filesystem>
#include <string>

#include "tests/support/process.h"

namespace driftwise::tests {

inline const std::filesystem::path kShippedCells =
    std::filesystem::path(DRIFTWISE_SOURCE_DIR) / "deploy/cells";

// A shipped cell and its plant with more in them, as a folder of cells.
class LargerCell {
 public:
  // instead of found: once in the shipped cell file.
  LargerCell(const std::string& from, const std::string& cell, const std::string& plant,
             const std::string& found = "", const std::string& instead = "") {
    const std::filesystem::path to = folder_.path();
    write_file(to / "plant.toml", read_file(kShippedCells / from / "plant.toml") + plant);
    std::string text = read_file(kShippedCells / from / "cell.toml");
    if (!found.empty()) text.replace(text.find(found), found.size(), instead);
    write_file(to / "cell.toml", text + cell);
  }
  std::string name() const { return std::filesystem::relative(folder_.path(), kShippedCells); }

 private:
  TemporaryFolder folder_;
};

// Three sensors of 0.5 V/mm with 0.1 mV of noise about the MinAngle's plate, and a servo
// inclinometer of +-5 V at +-20 degrees whose zero is 12 mV off.
inline constexpr const char* kSensorsOfThePlant = R"(
[voltage.gauge1]
input = 201
sees = "height"
x_mm = 40
y_mm = 0
volt_per_unit = 0.5
zero_v = 5
noise_v = 1e-4
limit_v = 10.5
[voltage.gauge2]
input = 202
sees = "height"
x_mm = -20
y_mm = 35
volt_per_unit = 0.5
zero_v = 5
noise_v = 1e-4
limit_v = 10.5
[voltage.gauge3]
input = 203
sees = "height"
x_mm = -20
y_mm = -35
volt_per_unit = 0.5
zero_v = 5
noise_v = 1e-4
limit_v = 10.5
[voltage.level]
input = 204
sees = "column"
column = "rx_arcsec"
curve = "sine"
volt_per_unit = 14.619
zero_v = 0.012
noise_v = 1e-4
limit_v = 5.5
)";

inline constexpr const char* kPlateAndLevel = R"(
[[device]]
id = "plate"
kind = "keithley-2701"
address = "127.0.0.1:1394"
timeout_s = 3.0
measures = "plate"
length = "z_mm"
tilt_x = "rx_arcsec"
tilt_y = "ry_arcsec"
[[device.sensor]]
input = 201
x_mm = 40
y_mm = 0
slope = 2
slope_unit = "mm/V"
zero_v = 5
min_v = 0.5
max_v = 9.5
u = 0.0002
[[device.sensor]]
input = 202
x_mm = -20
y_mm = 35
slope = 2
slope_unit = "mm/V"
zero_v = 5
min_v = 0.5
max_v = 9.5
u = 0.0002
[[device.sensor]]
input = 203
x_mm = -20
y_mm = -35
slope = 2
slope_unit = "mm/V"
zero_v = 5
min_v = 0.5
max_v = 9.5
u = 0.0002

[[device]]
id = "servo-level"
kind = "keithley-2701"
address = "127.0.0.1:1394"
timeout_s = 3.0
measures = "angle"
[[device.sensor]]
channel = "rx_arcsec"
input = 204
curve = "arcsine"
slope = 0.0684042
slope_unit = "1/V"
zero_v = 0.012
min_v = -5
max_v = 5
u = 5

[[setup]]
name = "plate"
[[setup.coordinate]]
channel = "z_mm"
device = "plate"
min = -5
max = 5
[[setup.coordinate]]
channel = "rx_arcsec"
device = "plate"
min = -20000
max = 20000
[[setup.coordinate]]
channel = "ry_arcsec"
device = "plate"
min = -20000
max = 20000

[[setup]]
name = "servo-level"
[[setup.coordinate]]
channel = "rx_arcsec"
device = "servo-level"
)";

// A beam of 0.5 V/N under the weights; the motor of axis 1 against a flexure of 2 N/mm with 0.4 N
// of friction, 0.25 V/N at its amplifier.
inline constexpr const char* kForcesOfThePlant = R"(
[voltage.beam]
input = 201
sees = "column"
column = "force_N"
volt_per_unit = 0.5
zero_v = 0.1
noise_v = 1e-4
limit_v = 10
[voltage.motor1]
input = 202
sees = "motor"
axis = 1
stiffness_n_mm = 2
friction_n = 0.4
travel_mm = 0.02
volt_per_unit = 0.25
noise_v = 1e-4
limit_v = 10
)";

inline constexpr const char* kForcesAndConfirmation = R"(
[[device]]
id = "beam"
kind = "keithley-2701"
address = "127.0.0.1:1394"
timeout_s = 3.0
period_s = 2.0
measures = "force"
[[device.sensor]]
channel = "beam_force_N"
input = 201
slope = 2
slope_unit = "N/V"
zero_v = 0.1
min_v = -4.5
max_v = 4.5
u = 0.01

[[device]]
id = "motor-1"
kind = "keithley-2701"
address = "127.0.0.1:1394"
timeout_s = 3.0
period_s = 2.0
measures = "motor-force"
axis = "q1_mm"
friction_n = 0.4
u_friction_n = 0.02
travel_mm = 0.02
[[device.sensor]]
channel = "motor_force_N"
input = 202
slope = 4
slope_unit = "N/V"
min_v = -9
max_v = 9
u = 0.01

[[setup]]
name = "confirmed"
[[setup.coordinate]]
channel = "x_mm"
device = "laser-x"
[[setup.coordinate]]
channel = "y_mm"
device = "laser-y"
[[setup.coordinate]]
channel = "z_mm"
device = "laser-z"
[[setup.coordinate]]
channel = "ry_arcsec"
device = "collimator-1"
[[setup.coordinate]]
channel = "rz_arcsec"
device = "collimator-1"
[[setup.coordinate]]
channel = "rx_arcsec"
device = "collimator-2"
[[setup.confirmation]]
channel = "rz_arcsec"
device = "collimator-2"
limit = 0.5
)";

// The Micro-Nano's second autocollimator sees rz as well.
inline constexpr const char* kSeesRx =
    "channel = \"rx_arcsec\"\ndevice_axis = 1\nsign = 1\nu_arcsec = 0.02\n";
inline constexpr const char* kSeesRxAndRz =
    "channel = \"rx_arcsec\"\ndevice_axis = 1\nsign = 1\nu_arcsec = 0.02\n\n"
    "[[device.angle]]\nchannel = \"rz_arcsec\"\ndevice_axis = 2\nsign = 1\nu_arcsec = 0.02\n";

}  // namespace driftwise::tests
