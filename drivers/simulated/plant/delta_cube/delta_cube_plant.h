#pragma once
// The Delta Cube 2 of the study's predecessors: a delta on flexures with three axes at right angles
// in a box at 25 degC, a mirror cube under three interferometers and two autocollimators, which a
// person carries from place to place: a run reads those of its set-up only. Time, noise and looking
// back: cell_plant.h; physics and choices: docs/plants/delta-cube-2.md.
//
// Interferometers 0, 1, 2 show x, y, z, + along the robot's axes. Autocollimator 0 looks along x:
// its y axis shows ry, its z axis rz. Autocollimator 1 looks along z: rx and ry.

#include "drivers/simulated/plant/cell/beam_path.h"
#include "drivers/simulated/plant/cell/cell_plant.h"
#include "drivers/simulated/plant/cell/recent_instants.h"
#include "drivers/simulated/plant/delta_cube/delta_cube_mechanics.h"

namespace driftwise::simulated {

class DeltaCubePlant final : public CellPlant {
 public:
  DeltaCubePlant(DeltaCubeParameters parameters, std::uint64_t seed, TimeNs epoch);

  int collimator_count() const override { return 2; }
  AngleReading measure_angle(int index, double average_s, TimeNs end) override;

  // Of the cube's centre in the robot's frame: the cube's own at scales 0 and the reference
  // temperature, tied to the faces of the robot that the measuring devices are tied to. Only
  // differences between two instants mean something.
  struct Pose {
    std::array<double, 3> position_nm{}, rotation_arcsec{};
  };
  Pose pose(double time_s) const;
  std::vector<std::string> truth_columns() const override;
  std::vector<double> truth_values(TimeNs at) override;
  const DeltaCubeParameters& parameters() const { return parameters_; }

 protected:
  Beam beam(int index, double time_s) const override;
  void before_command() override { recent_.forget(); }

 private:
  struct Instant {
    double time_s = 0;
    TimeNs now = 0;
    Frame frame;
    PerArm<ServoAxis::Position> servo{};
    Vec3 centre_mm;  // of the cube, base frame
    Rotation cube;   // against the reference pose
  };
  const Instant& instant(double time_s) const;
  void solve(Instant& i) const;
  CubeFace face(std::size_t axis, const Instant& at) const;
  LightRay ray(std::size_t axis) const;

  const DeltaCubeParameters& parameters_;  // the base's
  Machine machine_;
  DeltaCubeMechanics mechanics_;
  Vec3 reference_centre_mm_;
  Rotation reference_turn_;
  std::vector<Random> angle_noise_;
  mutable RecentInstants<Instant> recent_;  // forgotten at every command
};

}  // namespace driftwise::simulated
