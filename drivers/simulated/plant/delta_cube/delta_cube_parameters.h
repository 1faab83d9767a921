#pragma once
// Parameters of the Delta Cube 2 beyond the cell's. Names, units and sources:
// deploy/cells/delta-cube-2/plant.toml.

#include "drivers/simulated/plant/micro_nano/micro_nano_parameters.h"

namespace driftwise::simulated {

struct DeltaCubeParameters : CellParameters {
  std::uint64_t machine = 0;  // 0: drawn with the plant's seed; else this machine
  DeltaParameters delta;      // without azimuths and column_radius_mm: the axes are x, y and z
  ToleranceParameters tolerance;
  CubeParameters cube;
  PerArm<BeamParameters> beams{};
  OpticsParameters optics;  // without the fold: three straight beams
  CollimatorParameters collimator;
};

}  // namespace driftwise::simulated
