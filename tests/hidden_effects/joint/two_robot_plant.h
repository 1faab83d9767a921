#pragma once
// A MinAngle that holds the work-piece under a Micro-Nano that carries the tool, in a room that
// drifts. Made from the study's description alone (chapter 7: strokes, sizes, parasitic motions and
// their temperatures, instruments); shares no code with the product. Parameters are drawn once per
// plant from the ranges below and are not fitted to anything.
//
// MinAngle: three vertical screws at about 60 mm, 120 degrees apart, scales of 0.25 um. Its
// end-effector moves sideways with height (+-7 um in x, +-27 um in y over +-4 mm), with the
// temperature of its structure (0.7 and 1.7 um/K) and a little with its tilt (the measured model
// knows nothing of that).
// Micro-Nano: three orthogonal axes whose arms of 70 mm curve its motion; expands with the room;
// its end-effector tilts by up to 50 arcsec over 2.5 mm (a cubic surface), about its reference
// point.
//
// Lengths in mm, angles in arcsec, temperatures in degC, time in s.

#include <array>
#include <cstdint>
#include <random>

namespace joint_plant {

struct Pose {
  double x = 0, y = 0, z = 0, rx = 0, ry = 0, rz = 0;
};

// The room and what follows it: each structure by its own time constant, integrated in 10 s steps.
class Room {
 public:
  Room(std::uint64_t seed, double start_degc, double end_degc, double hours);
  void advance(double seconds);
  double now_s() const { return now_s_; }
  // Thermometers, with noise of 2 mK.
  double t05(), t08(), t09();
  // What the metal really is.
  double support_degc() const { return support_; }
  double screws_degc() const { return screws_; }
  double structure_degc() const { return structure_; }

 private:
  double air() const;
  double noisy(double value);
  double start_, end_, seconds_, wave_phase_, now_s_ = 0;
  double support_, screws_, structure_;
  std::mt19937_64 random_;
};

class MinAngle {
 public:
  explicit MinAngle(std::uint64_t seed);
  // The end-effector at these motor coordinates, as the scales count them (0.25 um).
  Pose pose(const std::array<double, 3>& q, const Room& room) const;
  // What the scales say once the motors hold these: the count that they hold.
  static std::array<double, 3> read_back(const std::array<double, 3>& q);
  // Motor coordinates at which the robot stands at this rx, ry, z, were the scales finer.
  std::array<double, 3> motors_at(double rx, double ry, double z, const Room& room) const;

 private:
  std::array<double, 3> radius_, azimuth_;
  double screw_um_per_k_, dx_per_k_, dy_per_k_, tilt_lever_mm_;
  std::array<double, 3> dx_, dy_;  // um per mm, mm^2, mm^3 of height
};

class MicroNano {
 public:
  explicit MicroNano(std::uint64_t seed);
  Pose pose(const std::array<double, 3>& q, const Room& room) const;
  std::array<double, 3> motors_at(double x, double y, double z, const Room& room) const;

 private:
  std::array<double, 3> arm_mm_, squareness_, um_per_k_;
  std::array<std::array<double, 9>, 3> tilt_;  // arcsec, of a cubic surface
};

// Instruments: what they would read of a pose.
class Instruments {
 public:
  explicit Instruments(std::uint64_t seed) : random_(seed) {}
  double laser_mm(double true_mm);                 // 10 nm
  double collimator_arcsec(double true_arcsec);    // 0.05 arcsec
  double inclinometer_arcsec(double true_arcsec);  // counts of 36 arcsec
  double probe_mm(double true_mm);  // dry friction: lags by 1 um behind its motion; counts of 50 nm

 private:
  std::mt19937_64 random_;
  double stuck_mm_ = 0;
};

}  // namespace joint_plant
