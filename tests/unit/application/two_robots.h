#pragma once
// Two small worlds as one cell: robot "ma" with everything that the small world has, robot "mn"
// with a controller and an axis. They hang opposite each other: each millimetre of either brings
// them a millimetre nearer, from 5 mm, and 1 mm is the least.

#include <utility>

#include "tests/support/cell_in_memory.h"

namespace driftwise::tests {

inline CellDescription two_robot_cell(const std::string& database) {
  auto cell = small_cell(database);
  cell.devices[0].become<MotionSettings>().axes.front().channel.symbol = "ma.q1";
  cell.devices[2].become<LengthSettings>().channel.symbol = "ma.x";
  auto second = cell.devices[0];
  second.id = "second";
  second.become<MotionSettings>().axes.front().channel.symbol = "mn.q1";
  cell.devices.push_back(second);
  cell.robots = {{"ma", "axis", {{"ma.q1", "mm"}}, "", {}},
                 {"mn", "second", {{"mn.q1", "mm"}}, "", {}}};
  cell.keep_outs = {{"tips", 1, 5, {{{"ma.q1", "mm"}, -1}, {{"mn.q1", "mm"}, -1}}, {"ma", "mn"}}};
  return cell;
}

inline CellInMemory::MakeDevices two_robot_devices(SmallWorld& ma, SmallWorld& mn) {
  return [&ma, &mn](VirtualTime& time, const CellDescription& cell) {
    auto devices = small_devices(ma, time, cell);
    auto other = cell;
    std::swap(other.devices.front(), other.devices.back());
    devices.push_back(std::move(small_devices(mn, time, other).front()));
    return devices;
  };
}

// Rows of both: {ma, mn} in mm, in lines that begin with a return to zero.
inline std::string rows_of_both(int lines, const std::vector<std::pair<double, double>>& places) {
  std::string csv = "ma.q1_mm,mn.q1_mm,set,line,zero\n";
  for (int line = 1; line <= lines; ++line) {
    const std::string of_line = ",calibration," + std::to_string(line);
    csv += "0,0" + of_line + ",1\n";
    for (const auto& [ma, mn] : places)
      csv += std::to_string(ma) + "," + std::to_string(mn) + of_line + ",0\n";
  }
  return csv;
}

}  // namespace driftwise::tests
