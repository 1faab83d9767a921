#pragma once
// The MinAngle of the published study, case C.1: an end-effector on three vertical screws, which
// turns about x and y and moves along z. Time, noise and looking back: cell_plant.h; physics and
// choices: docs/plants/min-angle.md.
//
// Lengths 0, 1, 2 are interferometers along x, y, z; length 3 is the touch probe below the
// end-effector, absolute. Angles 0 and 1 are autocollimators, along x (ry, rz) and along y (rx,
// rz); angle 2 is the inclinometer (rx, ry).

#include <array>

#include "drivers/simulated/plant/cell/cell_plant.h"
#include "drivers/simulated/plant/min_angle/min_angle_parameters.h"
#include "drivers/simulated/plant/numbers/vector3.h"

namespace driftwise::simulated {

// Of the end-effector, at 20 degC and scales 0 everything is 0. The end-effector is turned by rx
// about x, then by ry about y, then by rz about z. position_mm: the middle of the three joints,
// which is the centre of rotation.
struct MinAnglePose {
  std::array<double, 3> position_mm{};
  double rx_rad = 0, ry_rad = 0, rz_rad = 0;
};

class MinAnglePlant final : public CellPlant {
 public:
  MinAnglePlant(MinAngleParameters parameters, std::uint64_t seed, TimeNs epoch);

  void advance_to(TimeNs now) override;
  int interferometer_count() const override { return kTouchProbe + 1; }
  LengthReading measure_length(int index, TimeNs start, int samples) override;
  void zero_length(int index, TimeNs now) override;
  void set_dead_path_mm(int index, double mm) override;
  int collimator_count() const override { return kInclinometer + 1; }
  AngleReading measure_angle(int index, double average_s, TimeNs end) override;

  // Accident: knocked off, the probe's tip touches again after the next homing.
  void break_beam(TimeNs now, int index = 0) override;
  void start_reference(int index, TimeNs now) override;

  MinAnglePose pose(double time_s) const;
  std::vector<std::string> truth_columns() const override;
  std::vector<double> truth_values(TimeNs at) override;
  const MinAngleParameters& parameters() const { return parameters_; }

 protected:
  Beam beam(int index, double time_s) const override;

 private:
  static constexpr int kTouchProbe = 3, kInclinometer = 2;
  double joint_height_mm(std::size_t screw, double time_s, const Frame& frame) const;
  MinAnglePose pose(double time_s, const Frame& frame) const;
  Vec3 cube_mm(const MinAnglePose& pose) const;
  AngleReading read_inclinometer(double middle_s);
  AngleReading read_collimator(int index, double average_s, double middle_s);

  const MinAngleParameters& parameters_;  // the base's
  std::vector<Random> angle_noise_;
  Random probe_noise_;
  double tip_mm_ = 0;      // where dry friction holds the probe's tip
  double next_tip_s_ = 0;  // next instant of its grid
  bool knocked_off_ = false;
};

}  // namespace driftwise::simulated
