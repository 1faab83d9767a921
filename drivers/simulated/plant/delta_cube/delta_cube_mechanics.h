#pragma once
// Pose of the Delta Cube 2's platform: made geometry, warmed up, under its weight.
//
// Base frame: x, y, z along the three axes, z up, origin in the middle of the platform's joints
// with all scales at 0 in the nominal geometry at the reference temperature. Carriage i stands on
// the + side of axis i; its arm lies along the axis at pose zero. The pair of bars of axis x is
// spread along y, that of y along z, that of z along x: so no turn of the platform is free. Nothing
// is linearised.

#include "drivers/simulated/plant/delta_cube/delta_cube_parameters.h"
#include "drivers/simulated/plant/micro_nano/micro_nano_mechanics.h"

namespace driftwise::simulated {

// One Delta Cube 2 as it was made. The same seed makes the same machine.
Machine made_delta_cube(const DeltaCubeParameters& parameters, std::uint64_t seed);

class DeltaCubeMechanics {
 public:
  // Both must outlive the object.
  DeltaCubeMechanics(const DeltaCubeParameters& parameters, const Machine& machine)
      : parameters_(parameters), machine_(machine) {}

  // stage_mm: the stages' true positions on their guides.
  PlatformPose pose(const PerArm<double>& stage_mm, const NodeTemperatures& degc) const;
  // A point of the platform's frame that moves with its material.
  Vec3 on_platform(const PlatformPose& pose, Vec3 point_mm, const NodeTemperatures& degc) const;
  double stage_from_scale_mm(std::size_t axis, double scale_mm, const NodeTemperatures& degc) const;

 private:
  Bar bar(std::size_t k, double stage_mm, const NodeTemperatures& degc) const;
  double warm_k(int part, const NodeTemperatures& degc) const {
    return degc[static_cast<std::size_t>(part)] - parameters_.reference_degc;
  }

  const DeltaCubeParameters& parameters_;
  const Machine& machine_;
};

}  // namespace driftwise::simulated
