#pragma once
// Parameters of the MinAngle's plant beyond the cell's. Names, units and sources:
// deploy/cells/min-angle/plant.toml.

#include <array>
#include <vector>

#include "drivers/simulated/plant/micro_nano/micro_nano_parameters.h"

namespace driftwise::simulated {

inline constexpr std::size_t kScrews = 3;

struct ScrewParameters {
  double radius_mm = 0, azimuth_deg = 0;  // of its joint, on the end-effector
  double leg_mm = 0;                      // flexure between nut and joint
  std::array<double, 2> lean_mrad{};      // of its guide, towards x and y
  double scale_ppm = 0;                   // division error of its scale
};

struct EndEffectorParameters {
  double shortening_factor = 0;  // of a leg bent into an S
  double cube_below_mm = 0;      // cube's centre, below the middle of the joints
  WarmLength x, y;               // structure: carries the end-effector sideways as it warms
  std::array<WarmLength, kScrews> height{};  // support and screw below a joint
};

struct TouchProbeParameters {
  double friction_um = 0;  // full width of the tip's hysteresis; 0: an ideal tip
  double lean_deg = 0;     // of its axis from the vertical
  double range_mm = 0;     // half of its way, about the end-effector's zero
  double noise_nm = 0;     // of one value
};

struct InclinometerParameters {
  double step_deg = 0, noise_arcsec = 0;
  double range_deg = 0;
};

struct MinAngleParameters : CellParameters {
  std::array<ScrewParameters, kScrews> screws{};
  EndEffectorParameters end_effector;
  TouchProbeParameters probe;
  InclinometerParameters inclinometer;
  std::array<BeamParameters, 3> beams{};
  double tilt_limit_arcsec = 0;  // beyond it the light does not come back
  CollimatorParameters collimator;
  double mirror_arcsec_per_k = 0;  // turn of the 45 degree mirror before the first autocollimator
};

}  // namespace driftwise::simulated
