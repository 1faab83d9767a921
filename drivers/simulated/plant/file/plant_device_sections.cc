#include "drivers/simulated/plant/file/plant_sections.h"

namespace driftwise::simulated {

AxisParameters axis_section(Fields& f) {
  AxisParameters axis{.min_mm = f.number("min_mm"),
                      .max_mm = f.number("max_mm"),
                      .scale_resolution_nm = f.positive("scale_resolution_nm"),
                      .scale_error_ppm = f.within("scale_error_ppm", -1000, 1000),
                      .scale_noise_nm = f.not_negative("scale_noise_nm"),
                      .velocity_mm_s = f.positive("velocity_mm_s"),
                      .acceleration_mm_s2 = f.positive("acceleration_mm_s2"),
                      .start_delay_s = f.not_negative("start_delay_s"),
                      .resonance_hz = f.positive("resonance_hz"),
                      .damping = f.within("damping", 0.001, 0.99),
                      .ring_nm_per_mm_s2 = f.not_negative("ring_nm_per_mm_s2"),
                      .window_nm = f.positive("window_nm"),
                      .window_s = f.not_negative("window_s"),
                      .hold_min_nm = f.not_negative("hold_min_nm"),
                      .hold_max_nm = f.not_negative("hold_max_nm"),
                      .hold_wander_nm = f.not_negative("hold_wander_nm"),
                      .hold_wander_s = f.positive("hold_wander_s"),
                      .hold_jitter_nm = f.not_negative("hold_jitter_nm"),
                      .reference_s = f.positive("reference_s"),
                      .reference_repeatability_nm = f.not_negative("reference_repeatability_nm"),
                      .reference_offset_mm = f.number("reference_offset_mm"),
                      .stiffness_n_mm = f.not_negative("stiffness_n_mm"),
                      .motor_constant_n_sqrtw = f.positive("motor_constant_n_sqrtw"),
                      .moving_mass_kg = f.positive("moving_mass_kg")};
  if (axis.max_mm <= axis.min_mm) f.fail("max_mm", "is not above min_mm, expected a range");
  if (axis.hold_max_nm < axis.hold_min_nm) {
    f.fail("hold_max_nm", "is below hold_min_nm, expected a range");
  }
  return axis;
}

RoomParameters room_section(Fields f) {
  constexpr double kNever_h = 1e9;
  RoomParameters room{.ac_off_hours = f.has("ac_off_hours") ? f.number("ac_off_hours") : kNever_h,
                      .set_point_degc = f.within("set_point_degc", 5, 40),
                      .balance_degc = f.within("balance_degc", 5, 40),
                      .ac_w_k = f.positive("ac_w_k"),
                      .wall_w_k = f.positive("wall_w_k"),
                      .air_j_k = f.positive("air_j_k"),
                      .mass_j_k = f.positive("mass_j_k"),
                      .air_mass_w_k = f.positive("air_mass_w_k"),
                      .cycle_s = f.within("cycle_s", 10, 1e5),
                      .cycle_spread = f.within("cycle_spread", 0, 0.5),
                      .cycle_w = f.not_negative("cycle_w"),
                      .wander_w = f.not_negative("wander_w"),
                      .wander_s = f.positive("wander_s"),
                      .turbulence_k = f.not_negative("turbulence_k"),
                      .turbulence_s = f.positive("turbulence_s"),
                      .pressure_hpa = f.within("pressure_hpa", 500, 1100),
                      .pressure_wander_hpa = f.not_negative("pressure_wander_hpa"),
                      .pressure_wander_h = f.positive("pressure_wander_h"),
                      .humidity_pct = f.within("humidity_pct", 0, 100),
                      .humidity_wander_pct = f.not_negative("humidity_wander_pct"),
                      .humidity_wander_h = f.positive("humidity_wander_h")};
  for (const auto& row : f.rows("schedule", 2)) {
    if (!room.schedule.empty() && row[0] <= room.schedule.back().hours) {
      f.fail("schedule", "hours do not increase, expected [hours, degC] in order");
    }
    room.schedule.push_back({.hours = row[0], .degc = row[1]});
  }
  f.finish();
  return room;
}

InterferometerParameters interferometer_section(Fields& f,
                                                const std::vector<PartParameters>& parts) {
  InterferometerParameters device{.sample_rate_hz = f.within("sample_rate_hz", 10, 1e6),
                                  .resolution_nm = f.positive("resolution_nm"),
                                  .wavelength_nm = f.within("wavelength_nm", 300, 2000),
                                  .vibration_nm = f.not_negative("vibration_nm"),
                                  .vibration_s = f.positive("vibration_s"),
                                  .instability_nm = f.not_negative("instability_nm"),
                                  .instability_s = f.positive("instability_s"),
                                  .beam_turbulence_k = f.not_negative("beam_turbulence_k"),
                                  .air_part = part_named(f, "air_part", parts),
                                  .air_probe_s = f.positive("air_probe_s"),
                                  .air_probe_noise_k = f.not_negative("air_probe_noise_k"),
                                  .air_probe_resolution_k = f.positive("air_probe_resolution_k"),
                                  .air_probe_period_s = f.positive("air_probe_period_s"),
                                  .level_pct = f.within("level_pct", 0, 100),
                                  .disturbances_per_hour = f.not_negative("disturbances_per_hour"),
                                  .disturbance_nm = f.not_negative("disturbance_nm"),
                                  .disturbance_min_s = f.positive("disturbance_min_s"),
                                  .disturbance_max_s = f.positive("disturbance_max_s")};
  if (device.disturbance_max_s < device.disturbance_min_s) {
    f.fail("disturbance_max_s", "is below disturbance_min_s, expected a range");
  }
  return device;
}

StabiliserParameters stabiliser_section(Fields& f) {
  StabiliserParameters s{.set_point_degc = f.within("set_point_degc", 5, 60),
                         .seebeck_v_k = f.positive("seebeck_v_k"),
                         .resistance_ohm = f.positive("resistance_ohm"),
                         .conductance_w_k = f.not_negative("conductance_w_k"),
                         .current_limit_a = f.positive("current_limit_a"),
                         .heat_band_k = f.positive("heat_band_k"),
                         .cool_band_k = f.positive("cool_band_k"),
                         .integral_s = f.not_negative("integral_s"),
                         .derivative_s = f.not_negative("derivative_s"),
                         .sensor_s = f.positive("sensor_s"),
                         .sensor_noise_k = f.not_negative("sensor_noise_k"),
                         .sensor_drift_k = f.not_negative("sensor_drift_k"),
                         .sensor_drift_s = f.positive("sensor_drift_s"),
                         .process_resolution_k = f.positive("process_resolution_k")};
  const std::string mode = f.text("mode");
  if (mode == "automatic") {
    s.mode = Plant::StabiliserMode::automatic;
  } else if (mode == "off") {
    s.mode = Plant::StabiliserMode::off;
  } else {
    f.fail("mode", "found '" + mode + "', expected automatic or off");
  }
  return s;
}

}  // namespace driftwise::simulated
