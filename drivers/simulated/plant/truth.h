#pragma once
// What really is, at one instant: known to tests and to the demo's last table only, never to the
// daemon.

#include <string>
#include <vector>

#include "drivers/simulated/plant/plant.h"

namespace driftwise::simulated {

// Positions in nm along the beam, + away from the interferometer. Frame: the flange where the
// interferometer's bridge meets the robot's base, which is the robot's own reference. Thermal parts
// count from lengths at 20 degC, so only differences between two instants mean something: subtract
// the row at the run's zero.
struct Truth {
  TimeNs time = 0;
  double commanded_nm = 0;
  double q_scale_nm = 0;       // scale without quantisation and jitter
  double end_effector_nm = 0;  // of the mirror in the frame above: what accuracy is judged by
  double interferometer_true_nm =
      0;                       // mirror against the head: end_effector_nm - head's own motion
  double robot_drift_nm = 0;   // thermal part of end_effector_nm at this stage position
  double device_drift_nm = 0;  // thermal part of interferometer_true_nm that is the device's
  double air_error_nm = 0;  // air and electronics: reading - interferometer_true_nm since its zero
  double geometry_nm = 0;   // end_effector_nm without thermal parts
  double air_degc = 0, room_degc = 0, pressure_hpa = 0;
  std::vector<double> node_degc{};  // in the order of LinearAxisPlant::node_names()
};

}  // namespace driftwise::simulated
