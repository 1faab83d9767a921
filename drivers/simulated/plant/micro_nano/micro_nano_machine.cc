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

// Distance of one of the two bars of an arm from its middle.
double along_mm(std::size_t side, const DeltaParameters& delta) {
  return (side == 0 ? -0.5 : 0.5) * delta.pair_spacing_mm;
}

}  // namespace

void make_stage(Carriage& carriage, const DeltaParameters& delta,
                const ToleranceParameters& tolerance, Random& random) {
  for (auto& leg : carriage.leg_mm) leg = delta.leg_mm + tolerance.leg_mm * random.gaussian();
  for (std::size_t side = 0; side < 2; ++side)
    carriage.joint_mm[side] =
        along_mm(side, delta) * carriage.tangent + gaussian_vector(random, tolerance.joint_mm);
  carriage.scale_ppm = tolerance.scale_ppm * random.gaussian();
}

void make_arm(Machine& machine, std::size_t arm, const DeltaParameters& delta,
              const ToleranceParameters& tolerance, Random& random) {
  const auto& carriage = machine.carriages[arm];
  for (std::size_t side = 0; side < 2; ++side) {
    const std::size_t bar = 2 * arm + side;
    machine.platform_joint_mm[bar] = delta.platform_radius_mm * carriage.outward +
                                     along_mm(side, delta) * carriage.tangent +
                                     gaussian_vector(random, tolerance.joint_mm);
    machine.bar_mm[bar] = delta.arm_mm + tolerance.bar_mm * random.gaussian();
  }
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
  make_stage(c, d, t, random);
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
  Random robot(seed, "machine.robot"), optics(seed, "machine.optics");
  for (std::size_t i = 0; i < kArms; ++i) {
    machine.carriages[i] = made_carriage(p, i, robot);
    make_arm(machine, i, p.delta, p.tolerance, robot);
  }
  make_optics(machine, kFaces, p.cube, p.optics, p.collimator, optics);
  return machine;
}

}  // namespace driftwise::simulated
