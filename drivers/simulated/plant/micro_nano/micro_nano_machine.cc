#include "drivers/simulated/plant/micro_nano/micro_nano_machine.h"

#include <numbers>

#include "drivers/simulated/plant/numbers/random.h"
#include "drivers/simulated/plant/numbers/units.h"

namespace driftwise::simulated {
namespace {

Vec3 gaussian_vector(Random& random, double sigma) {
  const double x = random.gaussian(), y = random.gaussian(), z = random.gaussian();
  return {sigma * x, sigma * y, sigma * z};
}

Carriage made_carriage(const MicroNanoParameters& p, std::size_t i, Random& random) {
  const auto& d = p.delta;
  const auto& t = p.tolerance;
  Carriage c;
  c.azimuth_rad = d.azimuth_deg[i] * std::numbers::pi / 180;
  c.outward = {std::cos(c.azimuth_rad), std::sin(c.azimuth_rad), 0};
  c.tangent = {-std::sin(c.azimuth_rad), std::cos(c.azimuth_rad), 0};
  c.place_error_mm = gaussian_vector(random, t.column_mm);
  const Vec3 lean = gaussian_vector(random, t.guide_mrad * 1e-3);
  c.guide = unit(Vec3{lean.x, lean.y, 1});
  c.mounted = rotation_by(gaussian_vector(random, t.mount_mrad * 1e-3));
  // Parallel hinge axes leave no turn; skewed ones turn the stage about the two other directions.
  const Vec3 skew = gaussian_vector(random, t.skew_mrad * 1e-3);
  c.skew = skew.y * c.tangent + skew.z * Vec3{0, 0, 1};
  for (auto& leg : c.leg_mm) leg = d.leg_mm + t.leg_mm * random.gaussian();
  for (std::size_t side = 0; side < 2; ++side) {
    const double along_mm = (side == 0 ? -0.5 : 0.5) * d.pair_spacing_mm;
    c.joint_mm[side] = along_mm * c.tangent + gaussian_vector(random, t.joint_mm);
  }
  c.scale_ppm = t.scale_ppm * random.gaussian();
  return c;
}

constexpr PerArm<Vec3> kFaces{Vec3{-1, 0, 0}, Vec3{0, -1, 0}, Vec3{0, 0, 1}};

}  // namespace

Machine made_machine(const MicroNanoParameters& p, std::uint64_t seed) {
  Machine machine;
  const auto& d = p.delta;
  Random robot(seed, "machine.robot"), optics(seed, "machine.optics");
  for (std::size_t i = 0; i < kArms; ++i) {
    auto& c = machine.carriages[i] = made_carriage(p, i, robot);
    for (std::size_t side = 0; side < 2; ++side) {
      const double along_mm = (side == 0 ? -0.5 : 0.5) * d.pair_spacing_mm;
      machine.platform_joint_mm[2 * i + side] = d.platform_radius_mm * c.outward +
                                                along_mm * c.tangent +
                                                gaussian_vector(robot, p.tolerance.joint_mm);
      machine.bar_mm[2 * i + side] = d.arm_mm + p.tolerance.bar_mm * robot.gaussian();
    }
  }
  for (std::size_t i = 0; i < kArms; ++i) {
    auto& mirror = machine.mirrors[i];
    const Vec3 turn = gaussian_vector(optics, p.cube.facet_arcsec * kRadPerArcsec);
    mirror.normal = rotation_by(turn) * kFaces[i];
    for (auto& figure : mirror.figure) figure = 0.5 * p.cube.flatness_nm * optics.gaussian();
    for (auto& error : machine.spot_error_mm[i]) {
      error = optics.uniform(-p.optics.offset_mm, p.optics.offset_mm);
    }
    machine.beam_error_rad[i] = gaussian_vector(optics, p.optics.alignment_arcsec * kRadPerArcsec);
  }
  for (auto& collimator : machine.collimators) {
    const auto& c = p.collimator;
    collimator = {.y_offset_arcsec = c.alignment_arcsec * optics.gaussian(),
                  .z_offset_arcsec = c.alignment_arcsec * optics.gaussian(),
                  .roll_rad = c.roll_mrad * 1e-3 * optics.gaussian(),
                  .gain = 1 + c.scale_error * optics.gaussian()};
  }
  return machine;
}

}  // namespace driftwise::simulated
