#include "drivers/simulated/plant/linear_axis/linear_axis_plant.h"

#include "drivers/simulated/plant/linear_axis/measuring_loop.h"
#include "drivers/simulated/plant/numbers/units.h"

namespace driftwise::simulated {

struct LinearAxisPlant::Instant {
  Frame frame;
  ServoAxis::Position servo;
  LoopState loop;
  double disturbed_nm = 0;  // of the reading
};

LinearAxisPlant::LinearAxisPlant(LinearAxisParameters parameters, std::uint64_t seed, TimeNs epoch)
    : CellPlant(std::make_unique<const LinearAxisParameters>(std::move(parameters)), seed, epoch),
      parameters_(static_cast<const LinearAxisParameters&>(cell())) {
  zero_at_start();
}

LinearAxisPlant::Instant LinearAxisPlant::instant(double time_s) const {
  Instant i;
  i.frame = world_.at(time_s);
  i.servo = axes_.front().at(time_s, i.frame.hold_wander_nm.front());
  double stage_mm = stage_from_scale_mm(parameters_, i.frame.degc, i.servo.scale_mm);
  DisturbanceContext context{.time_s = time_s,
                             .stage_mm = stage_mm,
                             .approach = i.servo.approach,
                             .since_move_s = i.servo.since_end_s};
  if (!disturbances_.empty()) {
    // The servo follows the scale, so an error of the scale moves the stage the other way.
    stage_mm -= disturbed(DisturbancePlace::scale_nm, context) / kNmPerMm;
    context.stage_mm = stage_mm;
  }
  if (!parameters_.hidden.empty()) {
    stage_mm +=
        hidden_stage_nm(0, i.frame, {.time_s = time_s, .stage_mm = i.servo.scale_mm}) / kNmPerMm;
  }
  i.loop = measuring_loop(parameters_, i.frame.degc, stage_mm);
  i.loop.geometry_nm += disturbed(DisturbancePlace::end_effector_nm, context);
  i.disturbed_nm = disturbed(DisturbancePlace::interferometer_nm, context);
  return i;
}

CellPlant::Beam LinearAxisPlant::beam(int, double time_s) const {
  const Instant i = instant(time_s);
  const double true_nm = i.loop.interferometer_nm();
  return {.frame = i.frame,
          .true_nm = true_nm,
          .disturbed_nm = i.disturbed_nm,
          .hidden_nm = hidden_beam_nm(0, i.frame, time_s, true_nm)};
}

Truth LinearAxisPlant::truth(TimeNs at) {
  const Instant i = instant(seconds(at));
  const double true_nm = i.loop.interferometer_nm();
  const double shown = shown_nm(0, {.frame = i.frame,
                                    .true_nm = true_nm,
                                    .disturbed_nm = i.disturbed_nm,
                                    .hidden_nm = hidden_beam_nm(0, i.frame, seconds(at), true_nm)});
  Truth truth{
      .time = at,
      .commanded_nm = axes_.front().commanded_mm() * kNmPerMm,
      .q_scale_nm = i.servo.counter_mm * kNmPerMm,
      .end_effector_nm = i.loop.end_effector_nm(),
      .interferometer_true_nm = true_nm,
      .robot_drift_nm = i.loop.robot_drift_nm,
      .device_drift_nm = i.loop.device_drift_nm,
      .air_error_nm = shown - (true_nm - true_at_zero_nm_.front()),
      .geometry_nm = i.loop.geometry_nm,
      .air_degc = i.frame.degc[static_cast<std::size_t>(parameters_.interferometer().air_part)],
      .room_degc = i.frame.weather.room_degc,
      .pressure_hpa = i.frame.weather.pressure_hpa};
  truth.node_degc.assign(i.frame.degc.begin(),
                         i.frame.degc.begin() + static_cast<long>(node_names().size()));
  return truth;
}

std::vector<std::string> LinearAxisPlant::truth_columns() const {
  std::vector<std::string> columns{
      "commanded_nm",   "q_scale_nm",      "end_effector_nm", "interferometer_true_nm",
      "robot_drift_nm", "device_drift_nm", "air_error_nm",    "geometry_nm",
      "air_degC",       "room_degC",       "pressure_hPa"};
  for (const auto& name : node_names()) columns.push_back(name + "_degC");
  add_hidden_columns(columns);
  return columns;
}

std::vector<double> LinearAxisPlant::truth_values(TimeNs at) {
  const Truth t = truth(at);
  std::vector<double> values{
      t.commanded_nm,   t.q_scale_nm,      t.end_effector_nm, t.interferometer_true_nm,
      t.robot_drift_nm, t.device_drift_nm, t.air_error_nm,    t.geometry_nm,
      t.air_degc,       t.room_degc,       t.pressure_hpa};
  values.insert(values.end(), t.node_degc.begin(), t.node_degc.end());
  add_hidden_values(world_.at(seconds(at)), seconds(at), values);
  return values;
}

}  // namespace driftwise::simulated
