#pragma once
// The Agietron Micro-Nano of the published study, case B: a delta robot on flexures with three
// vertical linear axes, a mirror cube under three interferometers and two autocollimators, known
// weights that pull it upwards, ten pt1000 on scanner and structure. Time, noise and looking back:
// cell_plant.h; physics and choices: docs/plants/micro-nano.md.
//
// Interferometers 0, 1, 2 show x, y, z, + along the robot's axes. Autocollimator 0 looks along x:
// its y axis shows ry, its z axis rz. Autocollimator 1 looks along y: rx and rz.

#include <optional>

#include "drivers/simulated/plant/cell/beam_path.h"
#include "drivers/simulated/plant/cell/cell_plant.h"
#include "drivers/simulated/plant/cell/recent_instants.h"
#include "drivers/simulated/plant/micro_nano/load_rig.h"
#include "drivers/simulated/plant/micro_nano/micro_nano_mechanics.h"

namespace driftwise::simulated {

// Positions in nm and rotations in arcsec of the cube's centre and the cube, in the robot's frame:
// the cube's own at scales 0, 20 degC everywhere, no weights. Its origin is tied to the faces of
// the robot that the measuring devices are tied to. Only differences between two instants mean
// something: subtract the row at the run's zero.
struct PoseTruth {
  TimeNs time = 0;
  PerArm<double> commanded_nm{}, q_scale_nm{};             // scales without quantisation and jitter
  std::array<double, 3> position_nm{}, rotation_arcsec{};  // rotation vector
  std::array<double, 3> path_true_nm{};     // mirror against head, + along the robot's axis
  std::array<double, 3> device_drift_nm{};  // part of it that is the device's warmth
  std::array<double, 3> air_error_nm{};     // air and electronics: reading - path since the zero
  double force_n = 0, declared_n = 0;       // wire's pull less the pan's; what is said to hang
  double air_degc = 0, room_degc = 0, pressure_hpa = 0;
  std::vector<double> node_degc{};
};

class MicroNanoPlant : public CellPlant {
 public:
  MicroNanoPlant(MicroNanoParameters parameters, std::uint64_t seed, TimeNs epoch);

  int collimator_count() const override { return 2; }
  AngleReading measure_angle(int index, double average_s, TimeNs end) override;
  bool has_load() const override { return true; }
  LoadState load(TimeNs now) override;
  void set_load(double newton, TimeNs now) override;

  // Accidents.
  void set_load_jammed(bool jammed, TimeNs now);
  enum class CollimatorFault { none, wrong_power, wrong_position };
  void set_collimator_fault(int index, CollimatorFault fault, TimeNs now);

  PoseTruth truth(TimeNs at);
  std::vector<std::string> truth_columns() const override;
  std::vector<double> truth_values(TimeNs at) override;
  const MicroNanoParameters& parameters() const { return parameters_; }
  const Machine& machine() const { return machine_; }

 protected:
  Beam beam(int index, double time_s) const override;
  void before_command() override;
  double hidden_force_n(double time_s) const override;

  // Of the cube in the base's frame, against the reference pose.
  struct CubePose {
    Vec3 centre_mm;
    Vec3 turn_rad;  // rotation vector
  };
  CubePose cube_pose(double time_s) const;
  // After something outside the robot has moved its stages.
  void forget_instants() { recent_.forget(); }

 private:
  struct Instant {
    double time_s = 0;
    TimeNs now = 0;
    Frame frame;
    PerArm<ServoAxis::Position> servo{};
    double wire_mm = 0, tension_n = 0;
    Vec3 centre_mm;  // of the cube, base frame
    Rotation cube;   // against the reference pose
  };
  const Instant& instant(double time_s) const;
  void solve(Instant& i) const;
  Vec3 wire_end_mm(const PlatformPose& pose, const NodeTemperatures& degc) const;
  PathReading path(std::size_t axis, const Instant& at) const;
  CubeFace face(std::size_t axis, const Instant& at) const;
  LightRay ray(std::size_t axis, const Instant& at) const;
  double drift_arcsec(std::size_t index, double time_s) const;

  const MicroNanoParameters& parameters_;  // the base's
  Machine machine_;
  MicroNanoMechanics mechanics_;
  Vec3 reference_centre_mm_, pulley_mm_;
  Rotation reference_turn_;
  LoadRig load_;
  std::array<CollimatorFault, 2> collimator_faults_{};
  std::vector<Random> angle_noise_;
  mutable RecentInstants<Instant> recent_;  // forgotten at every command
};

}  // namespace driftwise::simulated
