#pragma once
// What the plant file of the linear axis says beyond the cell's: its measuring loop and geometry.

#include <string>
#include <vector>

#include "drivers/simulated/plant/plant_parameters.h"

namespace driftwise::simulated {

struct LoopParameters {
  std::string name{};
  std::vector<int> parts{};  // nodes, weighted by heat capacity
  bool robot = false;        // else the device's
  double length_mm = 0, expansion_per_k = 0;
};

struct BendingParameters {
  int top = 0, bottom = 0;
  double expansion_per_k = 0, node_distance_mm = 0, span_mm = 0, height_mm = 0;
};

struct ParallelogramParameters {
  int left_part = 0, right_part = 0;
  double expansion_per_k = 0;
  double left_length_mm = 0, right_length_mm = 0, shortening_factor = 0, spacing_mm = 0;
  double beam_above_scale_mm = 0, mirror_tilt_mrad = 0, beam_yaw_mrad = 0;
  int scale_part = 0;
  double scale_expansion_per_k = 0;
};

struct LinearAxisParameters : CellParameters {
  std::vector<LoopParameters> loop{};
  BendingParameters bending;
  ParallelogramParameters parallelogram;

  const AxisParameters& axis() const { return axes.front(); }
  const InterferometerParameters& interferometer() const { return interferometers.front(); }
};

}  // namespace driftwise::simulated
