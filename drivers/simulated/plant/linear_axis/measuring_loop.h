#pragma once
// From stage position and node temperatures to where the mirror is and what separates it from the
// interferometer.

#include "drivers/simulated/plant/linear_axis/linear_axis_parameters.h"
#include "drivers/simulated/plant/thermal/thermal_network.h"

namespace driftwise::simulated {

struct LoopState {
  double geometry_nm = 0;      // mirror along the beam, all parts at the reference temperature
  double robot_drift_nm = 0;   // what temperatures add to it: lengths, bending of the base, legs
  double device_drift_nm = 0;  // mirror - head, the device's own lengths
  double end_effector_nm() const { return geometry_nm + robot_drift_nm; }
  double interferometer_nm() const { return end_effector_nm() + device_drift_nm; }
};

LoopState measuring_loop(const LinearAxisParameters& plant, const NodeTemperatures& degc,
                         double stage_mm);

// The stage's position at which the scale shows scale_mm, and back: its error of division and its
// own expansion.
double stage_from_scale_mm(const LinearAxisParameters& plant, const NodeTemperatures& degc,
                           double scale_mm);

}  // namespace driftwise::simulated
