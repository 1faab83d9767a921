#include "drivers/simulated/plant/linear_axis/parallelogram.h"

#include <cmath>

namespace driftwise::simulated {
namespace {

double upper_end_mm(double length_mm, double factor, double stage_mm) {
  const double effective_mm = length_mm / (2 * factor);
  // e - sqrt(e^2 - x^2) without the loss of digits.
  const double drop_mm =
      stage_mm * stage_mm /
      (effective_mm + std::sqrt(effective_mm * effective_mm - stage_mm * stage_mm));
  return length_mm - drop_mm;
}

}  // namespace

StagePose stage_pose(const ParallelogramParameters& p, double stage_mm, double left_k,
                     double right_k) {
  const double left_mm = p.left_length_mm * (1 + p.expansion_per_k * left_k);
  const double right_mm = p.right_length_mm * (1 + p.expansion_per_k * right_k);
  const double left_end_mm = upper_end_mm(left_mm, p.shortening_factor, stage_mm);
  const double right_end_mm = upper_end_mm(right_mm, p.shortening_factor, stage_mm);
  const double upright_mm = (p.left_length_mm + p.right_length_mm) / 2;
  const double assembled_mm = p.right_length_mm - p.left_length_mm;  // levelled when it was glued
  return {.rise_mm = (left_end_mm + right_end_mm) / 2 - upright_mm,
          .pitch_rad = (right_end_mm - left_end_mm - assembled_mm) / p.spacing_mm};
}

double mirror_mm(const ParallelogramParameters& p, double stage_mm, const StagePose& pose) {
  return stage_mm * std::cos(p.beam_yaw_mrad * 1e-3) +
         pose.rise_mm * std::tan(p.mirror_tilt_mrad * 1e-3) -
         p.beam_above_scale_mm * std::sin(pose.pitch_rad);
}

}  // namespace driftwise::simulated
