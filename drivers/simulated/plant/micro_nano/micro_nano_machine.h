#pragma once
// One Micro-Nano as it was made: nominal geometry with the errors that workshop and assembly leave.

#include <array>
#include <cstdint>

#include "drivers/simulated/plant/micro_nano/micro_nano_parameters.h"
#include "drivers/simulated/plant/micro_nano/six_bars.h"
#include "drivers/simulated/plant/numbers/random.h"

namespace driftwise::simulated {

struct Carriage {
  double azimuth_rad = 0;
  Vec3 outward;  // unit, horizontal
  Vec3 tangent;  // unit: along the joint line and along the guide's legs
  Vec3 place_error_mm;
  Vec3 guide;        // unit: which way the stage goes
  Rotation mounted;  // of the joints against the stage
  Vec3 skew;         // rad of turn per rad of the legs' lean
  std::array<double, 2> leg_mm{};
  std::array<Vec3, 2> joint_mm{};  // from the stage's reference, as made
  double scale_ppm = 0;
};

struct Mirror {                    // a face of the cube
  Vec3 normal;                     // outward, cube's frame
  std::array<double, 3> figure{};  // of its flatness: u^2 - v^2, u v, u^2 + v^2 over the half edge
};

struct Machine {
  PerArm<Carriage> carriages{};
  std::array<Vec3, kBars> platform_joint_mm{};
  std::array<double, kBars> bar_mm{};
  PerArm<Mirror> mirrors{};                       // x, y, z
  PerArm<std::array<double, 2>> spot_error_mm{};  // of the beams' places, u and v
  PerArm<Vec3> beam_error_rad{};                  // of their directions
  struct Collimator {
    double y_offset_arcsec = 0, z_offset_arcsec = 0, roll_rad = 0, gain = 1;
  };
  std::array<Collimator, 2> collimators{};
};

Vec3 gaussian_vector(Random& random, double sigma);

// Mirrors (nominal normals: outward), places and directions of the beams, autocollimators.
void make_optics(Machine& machine, const PerArm<Vec3>& outward, const CubeParameters& cube,
                 const OpticsParameters& optics, const CollimatorParameters& collimator,
                 Random& random);

// Legs and joints of a stage, whose tangent is known, and its scale.
void make_stage(Carriage& carriage, const DeltaParameters& delta,
                const ToleranceParameters& tolerance, Random& random);
// The two bars of an arm, whose carriage is made, and their joints on the platform.
void make_arm(Machine& machine, std::size_t arm, const DeltaParameters& delta,
              const ToleranceParameters& tolerance, Random& random);

// The same seed makes the same machine.
Machine made_machine(const MicroNanoParameters& parameters, std::uint64_t seed);

}  // namespace driftwise::simulated
