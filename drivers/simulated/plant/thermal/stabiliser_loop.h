#pragma once
// The Peltier element under the interferometer's support and the controller that drives it, stepped
// at 10 Hz.
//
// Element (textbook relations, e.g. Goldsmid): into the support S T i + R i^2 / 2 when heating, -(S
// T i - R i^2 / 2) when cooling; out of or into the sink the same with the other sign of S T i; the
// conduction between both is a link of the thermal network. Controller: output = error / band +
// integral + derivative of the process value, in percent of the current limit, integral held while
// the output is at its limit.

#include <cstdint>

#include "drivers/simulated/plant/numbers/random.h"
#include "drivers/simulated/plant/plant_parameters.h"

namespace driftwise::simulated {

struct PeltierHeat {
  double support_w = 0, sink_w = 0;  // into each
};

class StabiliserLoop {
 public:
  StabiliserLoop(const StabiliserParameters& parameters, std::uint64_t seed, double step_s,
                 double start_degc, int index = 0);

  // One tick of sensor and controller; the heat that flows during the step that follows.
  PeltierHeat step(double support_degc, double sink_degc);

  StabiliserState state() const;
  void set_set_point_degc(double degc) { set_point_degc_ = degc; }
  void set_mode(Plant::StabiliserMode mode, double manual_pct);
  void set_tuning(double heat_band_k, double cool_band_k, double ti_s, double td_s);
  void set_sensor_open(bool open);

 private:
  double controlled_pct();

  StabiliserParameters parameters_;
  Random noise_;
  Wander drift_;  // of sensor and electronics: the loop follows it and does not see it
  double step_s_, keep_;
  double sensor_degc_, process_degc_, previous_degc_;
  double set_point_degc_;
  Plant::StabiliserMode mode_;
  double manual_pct_ = 0, integral_pct_ = 0, output_pct_ = 0;
  bool sensor_open_ = false;
};

}  // namespace driftwise::simulated
