#pragma once
// The private record of the truth: a CSV that only tests and the demo's final table read.
//
// Columns: time_ns (cell UTC), kind, commanded_nm, q_scale_nm, end_effector_nm,
// interferometer_true_nm, robot_drift_nm, device_drift_nm, air_error_nm, geometry_nm, air_degC,
// room_degC, pressure_hPa, then one <node>_degC per thermal node. kind: "zero" (the interferometer
// was zeroed), "length" (middle of a reading), "reference", "tick" (every 10 s). To judge a
// reading: the row of kind length whose time lies between the reading's start and end, minus the
// last row of kind zero before it. Numbers are shortest round trip. Every line is written to the
// file system at once.

#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/simulated/plant/truth.h"

namespace driftwise::simulated {

class TruthLog {
 public:
  // Creates or continues the file; a new one gets the header. Throws std::runtime_error when it
  // cannot be opened.
  TruthLog(const std::filesystem::path& file, std::span<const std::string> node_names);
  void append(std::string_view kind, const Truth& truth);

 private:
  std::ofstream out_;
};

}  // namespace driftwise::simulated
