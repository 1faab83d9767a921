#include "drivers/simulated/plant/micro_nano/micro_nano_mechanics.h"

#include <cmath>

namespace driftwise::simulated {
namespace {

constexpr double kGravity_m_s2 = 9.806;

}  // namespace

// e - sqrt(e^2 - x^2) without the loss of digits.
double drawn_in_mm(double leg_mm, double factor, double x_mm) {
  const double effective_mm = leg_mm / (2 * factor);
  return x_mm * x_mm / (effective_mm + std::sqrt(effective_mm * effective_mm - x_mm * x_mm));
}

double growth_mm(const WarmLength& length, double reference_degc, const NodeTemperatures& degc) {
  double warm_k = 0;
  for (const int part : length.parts) {
    warm_k += degc[static_cast<std::size_t>(part)] - reference_degc;
  }
  return length.mm * length.expansion_per_k * warm_k / static_cast<double>(length.parts.size());
}

double growth_mm(const std::vector<WarmLength>& lengths, double reference_degc,
                 const NodeTemperatures& degc) {
  double sum_mm = 0;
  for (const auto& length : lengths) sum_mm += growth_mm(length, reference_degc, degc);
  return sum_mm;
}

MicroNanoMechanics::MicroNanoMechanics(const MicroNanoParameters& parameters,
                                       const Machine& machine)
    : parameters_(parameters), machine_(machine) {
  const auto& d = parameters.delta;
  const double reach_mm = d.column_radius_mm - d.platform_radius_mm;
  drop_mm_ = std::sqrt(d.arm_mm * d.arm_mm - reach_mm * reach_mm);
}

double MicroNanoMechanics::warm_k(int part, const NodeTemperatures& degc) const {
  return degc[static_cast<std::size_t>(part)] - parameters_.reference_degc;
}

double MicroNanoMechanics::stage_from_scale_mm(std::size_t axis, double scale_mm,
                                               const NodeTemperatures& degc) const {
  const auto& d = parameters_.delta;
  return scale_mm / (1 + machine_.carriages[axis].scale_ppm * 1e-6) *
         (1 + d.scale_expansion_per_k * warm_k(d.scale_part[axis], degc));
}

Bar MicroNanoMechanics::bar(std::size_t k, double stage_mm, const NodeTemperatures& degc) const {
  const auto& d = parameters_.delta;
  const std::size_t arm = k / 2;
  const Carriage& c = machine_.carriages[arm];
  const double reference = parameters_.reference_degc;

  // The guide: two legs that lean by the same way but are not quite of one length.
  const double lean_mm = stage_mm - d.neutral_mm;
  const double first_mm = drawn_in_mm(c.leg_mm[0], d.shortening_factor, lean_mm);
  const double second_mm = drawn_in_mm(c.leg_mm[1], d.shortening_factor, lean_mm);
  const double pitch_rad = (second_mm - first_mm) / d.leg_spacing_mm;
  const Vec3 turn = pitch_rad * c.outward + (lean_mm / d.leg_mm) * c.skew;
  const Rotation turned = rotation_by(turn) * c.mounted;

  const double radius_mm = d.column_radius_mm + growth_mm(d.outwards[arm], reference, degc);
  const double height_mm = drop_mm_ + growth_mm(d.upwards[arm], reference, degc);
  const Vec3 stage = radius_mm * c.outward + Vec3{0, 0, height_mm} + c.place_error_mm +
                     stage_mm * c.guide - (first_mm + second_mm) / 2 * c.tangent;
  const double platform_k = d.platform_expansion_per_k * warm_k(d.platform_part, degc);
  return {.carriage_mm = stage + turned * c.joint_mm[k % 2],
          .platform_mm = (1 + platform_k) * machine_.platform_joint_mm[k],
          .length_mm =
              machine_.bar_mm[k] * (1 + d.arm_expansion_per_k * warm_k(d.arm_part[arm], degc))};
}

Assembly MicroNanoMechanics::assembly(const PerArm<double>& stage_mm,
                                      const NodeTemperatures& degc) const {
  Assembly a;
  double mean_mm = 0;
  for (const double stage : stage_mm) mean_mm += stage / static_cast<double>(kArms);
  for (std::size_t k = 0; k < kBars; ++k) a.bars[k] = bar(k, stage_mm[k / 2], degc);
  a.stiff = closed_pose(a.bars, {.centre_mm = {0, 0, mean_mm}, .turn = {}});
  for (std::size_t k = 0; k < kBars; ++k) a.swing_rad[k] = swing_rad(k, a);
  return a;
}

Vec3 MicroNanoMechanics::swing_rad(std::size_t k, const Assembly& a) const {
  const auto& d = parameters_.delta;
  const Bar& b = a.bars[k];
  const Vec3 along = unit(a.stiff.centre_mm + a.stiff.turn * b.platform_mm - b.carriage_mm);
  const Vec3 neutral =
      unit((d.platform_radius_mm - d.column_radius_mm) * machine_.carriages[k / 2].outward -
           Vec3{0, 0, drop_mm_});
  return cross(neutral, along);
}

PlatformPose rested(const Assembly& a, const DeltaParameters& d, const PerArm<Vec3>& tangents,
                    Vec3 attach_mm, Vec3 pull_n) {
  Wrench wrench{.force_n = pull_n - Vec3{0, 0, d.moving_kg * kGravity_m_s2},
                .moment_nmm = cross(attach_mm - a.stiff.centre_mm, pull_n)};
  for (std::size_t k = 0; k < kBars; ++k) {
    const Bar& b = a.bars[k];
    const Vec3 lever = a.stiff.turn * b.platform_mm;
    const Vec3 along = unit(a.stiff.centre_mm + lever - b.carriage_mm);
    // A bar that has swung is held back at both ends: a moment on the platform, and a shear.
    const Vec3 phi = a.swing_rad[k];
    const double turning = d.hinge.turning_nmm_rad();
    const Vec3 shear_n = (-2 * turning / b.length_mm) * cross(phi, along);
    wrench.force_n = wrench.force_n + shear_n;
    wrench.moment_nmm = wrench.moment_nmm + turning * phi + cross(lever, shear_n);
  }
  const auto forces_n = bar_forces_n(a.bars, a.stiff, wrench);
  std::array<Bar, kBars> bars = a.bars;
  for (std::size_t k = 0; k < kBars; ++k) {
    // Of the crossed blades at each end one bends when the bar swings in its arm's plane, the other
    // when it swings sideways.
    const double in_plane = dot(a.swing_rad[k], tangents[k / 2]);
    const double sideways = norm(a.swing_rad[k] - in_plane * tangents[k / 2]);
    const double give_mm_n =
        d.hinges_per_bar / 2.0 *
            (d.hinge.give_mm_n(in_plane, forces_n[k]) + d.hinge.give_mm_n(sideways, forces_n[k])) +
        bars[k].length_mm / (d.hinge.youngs_gpa * 1e3 * d.bar_section_mm2);
    bars[k].length_mm += give_mm_n * forces_n[k];
  }
  return closed_pose(bars, a.stiff);
}

PlatformPose MicroNanoMechanics::pulled(const Assembly& a, Vec3 attach_mm, Vec3 pull_n) const {
  PerArm<Vec3> tangents;
  for (std::size_t i = 0; i < kArms; ++i) tangents[i] = machine_.carriages[i].tangent;
  return rested(a, parameters_.delta, tangents, attach_mm, pull_n);
}

Vec3 MicroNanoMechanics::on_platform(const PlatformPose& pose, Vec3 point_mm,
                                     const NodeTemperatures& degc) const {
  const auto& d = parameters_.delta;
  const double warm = 1 + d.platform_expansion_per_k * warm_k(d.platform_part, degc);
  return pose.centre_mm + pose.turn * (warm * point_mm);
}

}  // namespace driftwise::simulated
