#include "drivers/simulated/plant/linear_axis/measuring_loop.h"

#include "drivers/simulated/plant/linear_axis/parallelogram.h"
#include "drivers/simulated/plant/numbers/units.h"

namespace driftwise::simulated {
namespace {

double node(const NodeTemperatures& degc, int index) {
  return degc[static_cast<std::size_t>(index)];
}

double piece_nm(const LinearAxisParameters& plant, const LoopParameters& piece,
                const NodeTemperatures& degc) {
  double heat = 0, capacity = 0;
  for (const int part : piece.parts) {
    const double c = plant.parts[static_cast<std::size_t>(part)].capacity_j_k;
    heat += c * (node(degc, part) - plant.reference_degc);
    capacity += c;
  }
  return piece.expansion_per_k * piece.length_mm * heat / capacity * kNmPerMm;
}

// A plate with one face warmer is a circle's arc: a point above its far end leans out by angle x
// height.
double bending_nm(const BendingParameters& b, const NodeTemperatures& degc) {
  const double curvature_per_mm =
      b.expansion_per_k * (node(degc, b.top) - node(degc, b.bottom)) / b.node_distance_mm;
  return curvature_per_mm * b.span_mm * b.height_mm * kNmPerMm;
}

}  // namespace

LoopState measuring_loop(const LinearAxisParameters& plant, const NodeTemperatures& degc,
                         double stage_mm) {
  const auto& p = plant.parallelogram;
  LoopState state;
  state.geometry_nm = mirror_mm(p, stage_mm, stage_pose(p, stage_mm, 0, 0)) * kNmPerMm;
  const StagePose pose = stage_pose(p, stage_mm, node(degc, p.left_part) - plant.reference_degc,
                                    node(degc, p.right_part) - plant.reference_degc);
  state.robot_drift_nm =
      mirror_mm(p, stage_mm, pose) * kNmPerMm - state.geometry_nm + bending_nm(plant.bending, degc);
  for (const auto& piece : plant.loop) {
    (piece.robot ? state.robot_drift_nm : state.device_drift_nm) += piece_nm(plant, piece, degc);
  }
  return state;
}

double stage_from_scale_mm(const LinearAxisParameters& plant, const NodeTemperatures& degc,
                           double scale_mm) {
  const auto& p = plant.parallelogram;
  const double warm_k = node(degc, p.scale_part) - plant.reference_degc;
  return scale_mm / (1 + plant.axis().scale_error_ppm * 1e-6) *
         (1 + p.scale_expansion_per_k * warm_k);
}

}  // namespace driftwise::simulated
