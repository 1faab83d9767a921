#pragma once
// A small cell for the tests of plausibility: one axis, one length, three probes and an air probe.

#include "server/core/data/judged_reading.h"
#include "server/core/description/cell_description.h"

namespace driftwise::plausibility {

inline constexpr double kNan = kMissing;

inline CellTime at_s(double seconds) { return CellTime{} + nanoseconds_from_s(seconds); }

inline CellDescription cell() {
  CellDescription cell;
  DeviceDescription axis;
  axis.id = "axis";
  axis.options["velocity_mm_s"] = "5";
  axis.become<MotionSettings>().axes.push_back({{"q1", "mm"}, "X", -5, 5, 0});
  DeviceDescription laser;
  laser.id = "laser-x";
  laser.become<LengthSettings>().channel = {"x", "mm"};
  DeviceDescription scanner;
  scanner.id = "scanner";
  for (const char* name : {"t01", "t02", "t03"}) {
    ProbeDescription probe;
    probe.channel = {name, "degC"};
    probe.part = "robot";
    scanner.become<TemperatureSettings>().probes.push_back(probe);
  }
  ProbeDescription air;
  air.channel = {"t04", "degC"};
  air.part = "air";
  scanner.become<TemperatureSettings>().probes.push_back(air);
  cell.devices = {axis, laser, scanner};
  auto& kinematics = cell.kinematics.emplace();
  kinematics.kind = "linear-axis";
  kinematics.axes.push_back({{"q1", "mm"}, {"x", "mm"}, 0, 0});
  return cell;
}

// One answer of the scanner, or of the laser.
inline JudgedReading scan(double time_s, std::vector<double> degc) {
  JudgedReading reading;
  reading.device = "scanner";
  reading.start = reading.end = at_s(time_s);
  const char* names[] = {"t01_degC", "t02_degC", "t03_degC", "t04_degC"};
  for (std::size_t i = 0; i < degc.size(); ++i) reading.values.push_back({names[i], degc[i]});
  return reading;
}
inline JudgedReading length(double time_s, double x_mm) {
  JudgedReading reading;
  reading.device = "laser-x";
  reading.start = reading.end = at_s(time_s);
  reading.values.push_back({"x_mm", x_mm});
  return reading;
}

}  // namespace driftwise::plausibility
