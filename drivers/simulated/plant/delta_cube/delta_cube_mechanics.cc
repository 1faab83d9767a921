#include "drivers/simulated/plant/delta_cube/delta_cube_mechanics.h"

#include <cmath>

namespace driftwise::simulated {
namespace {

constexpr PerArm<Vec3> kAxes{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
constexpr PerArm<Vec3> kSpread{Vec3{0, 1, 0}, Vec3{0, 0, 1}, Vec3{1, 0, 0}};
// Faces that no arm covers: the beams come from the - sides.
constexpr PerArm<Vec3> kSeenFaces{Vec3{-1, 0, 0}, Vec3{0, -1, 0}, Vec3{0, 0, -1}};

Carriage made_axis(const DeltaCubeParameters& p, std::size_t i, Random& random) {
  const auto& d = p.delta;
  const auto& t = p.tolerance;
  Carriage c;
  c.outward = kAxes[i];
  c.tangent = kSpread[i];
  const Vec3 third = cross(c.outward, c.tangent);
  c.place_error_mm = gaussian_vector(random, t.column_mm);
  const Vec3 lean = gaussian_vector(random, t.guide_mrad * 1e-3);
  c.guide = unit(c.outward + lean.x * c.tangent + lean.y * third);
  c.mounted = rotation_by(gaussian_vector(random, t.mount_mrad * 1e-3));
  // Parallel hinge axes leave no turn; skewed ones turn the stage about the two other directions.
  const Vec3 skew = gaussian_vector(random, t.skew_mrad * 1e-3);
  c.skew = skew.y * c.tangent + skew.z * c.outward;
  make_stage(c, d, t, random);
  return c;
}

}  // namespace

Machine made_delta_cube(const DeltaCubeParameters& p, std::uint64_t seed) {
  Machine machine;
  Random robot(seed, "machine.robot"), optics(seed, "machine.optics");
  for (std::size_t i = 0; i < kArms; ++i) {
    machine.carriages[i] = made_axis(p, i, robot);
    make_arm(machine, i, p.delta, p.tolerance, robot);
  }
  make_optics(machine, kSeenFaces, p.cube, p.optics, p.collimator, optics);
  return machine;
}

double DeltaCubeMechanics::stage_from_scale_mm(std::size_t axis, double scale_mm,
                                               const NodeTemperatures& degc) const {
  const auto& d = parameters_.delta;
  return scale_mm / (1 + machine_.carriages[axis].scale_ppm * 1e-6) *
         (1 + d.scale_expansion_per_k * warm_k(d.scale_part[axis], degc));
}

Bar DeltaCubeMechanics::bar(std::size_t k, double stage_mm, const NodeTemperatures& degc) const {
  const auto& d = parameters_.delta;
  const std::size_t arm = k / 2;
  const Carriage& c = machine_.carriages[arm];
  // The guide: two legs, spread along the axis, that lean by the same way but are not quite of one
  // length.
  const double lean_mm = stage_mm - d.neutral_mm;
  const double first_mm = drawn_in_mm(c.leg_mm[0], d.shortening_factor, lean_mm);
  const double second_mm = drawn_in_mm(c.leg_mm[1], d.shortening_factor, lean_mm);
  const double pitch_rad = (second_mm - first_mm) / d.leg_spacing_mm;
  const Vec3 turn = pitch_rad * cross(c.outward, c.tangent) + (lean_mm / d.leg_mm) * c.skew;
  const Rotation turned = rotation_by(turn) * c.mounted;

  const double out_mm = d.arm_mm + d.platform_radius_mm +
                        growth_mm(d.outwards[arm], parameters_.reference_degc, degc);
  const Vec3 stage = out_mm * c.outward + c.place_error_mm + stage_mm * c.guide -
                     (first_mm + second_mm) / 2 * c.tangent;
  const double platform_k = d.platform_expansion_per_k * warm_k(d.platform_part, degc);
  return {.carriage_mm = stage + turned * c.joint_mm[k % 2],
          .platform_mm = (1 + platform_k) * machine_.platform_joint_mm[k],
          .length_mm =
              machine_.bar_mm[k] * (1 + d.arm_expansion_per_k * warm_k(d.arm_part[arm], degc))};
}

PlatformPose DeltaCubeMechanics::pose(const PerArm<double>& stage_mm,
                                      const NodeTemperatures& degc) const {
  Assembly a;
  for (std::size_t k = 0; k < kBars; ++k) a.bars[k] = bar(k, stage_mm[k / 2], degc);
  a.stiff = closed_pose(a.bars, {.centre_mm = to_vec3(stage_mm), .turn = {}});
  PerArm<Vec3> tangents;
  for (std::size_t i = 0; i < kArms; ++i) tangents[i] = machine_.carriages[i].tangent;
  for (std::size_t k = 0; k < kBars; ++k) {
    const Bar& b = a.bars[k];
    const Vec3 along = unit(a.stiff.centre_mm + a.stiff.turn * b.platform_mm - b.carriage_mm);
    a.swing_rad[k] = cross(-1.0 * machine_.carriages[k / 2].outward, along);
  }
  return rested(a, parameters_.delta, tangents, a.stiff.centre_mm, {});
}

Vec3 DeltaCubeMechanics::on_platform(const PlatformPose& pose, Vec3 point_mm,
                                     const NodeTemperatures& degc) const {
  const auto& d = parameters_.delta;
  const double warm = 1 + d.platform_expansion_per_k * warm_k(d.platform_part, degc);
  return pose.centre_mm + pose.turn * (warm * point_mm);
}

}  // namespace driftwise::simulated
