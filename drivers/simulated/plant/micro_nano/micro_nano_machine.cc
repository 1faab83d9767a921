#include "drivers/simulated/plant/micro_nano/micro_nano_machine.h"

#include <numbers>

#include "drivers/simulated/plant/numbers/random.h"
#include "drivers/simulated/plant/numbers/units.h"

namespace driftwise::simulated {

Vec3 gaussian_vector(Random& random, double sigma) {
  const double x = random.gaussian(), y = random.gaussian(), z = random.gaussian();
  return {sigma * x, sigma * y, sigma * z};
}

namespace {

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

void make_optics(Machine& machine, const PerArm<Vec3>& outward, const CubeParameters& cube,
                 const OpticsParameters& optics, const CollimatorParameters& collimator,
                 Random& random) {
  for (std::size_t i = 0; i < kArms; ++i) {
    auto& mirror = machine.mirrors[i];
    const Vec3 turn = gaussian_vector(random, cube.facet_arcsec * kRadPerArcsec);
    mirror.normal = rotation_by(turn) * outward[i];
    for (auto& figure : mirror.figure) figure = 0.5 * cube.flatness_nm * random.gaussian();
    for (auto& error : machine.spot_error_mm[i]) {
      error = random.uniform(-optics.offset_mm, optics.offset_mm);
    }
    machine.beam_error_rad[i] = gaussian_vector(random, optics.alignment_arcsec * kRadPerArcsec);
  }
  for (auto& one : machine.collimators) {
    one = {.y_offset_arcsec = collimator.alignment_arcsec * random.gaussian(),
           .z_offset_arcsec = collimator.alignment_arcsec * random.gaussian(),
           .roll_rad = collimator.roll_mrad * 1e-3 * random.gaussian(),
           .gain = 1 + collimator.scale_error * random.gaussian()};
  }
}

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
  make_optics(machine, kFaces, p.cube, p.optics, p.collimator, optics);
  return machine;
}

}  // namespace driftwise::simulated
