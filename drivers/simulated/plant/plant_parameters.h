#pragma once
// What a plant file says, checked. Names, units and sources: deploy/cells/*/plant.toml, which are
// the manual. Lists are in the order of their names.

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/simulated/plant/hidden_parameters.h"
#include "drivers/simulated/plant/plant.h"

namespace driftwise::simulated {

struct Material {
  double density_kg_m3 = 0, heat_capacity_j_kgk = 0, conductivity_w_mk = 0, expansion_ppm_k = 0;
};

inline constexpr int kRoom = -1;  // the room's air: a boundary, not a node

struct PartParameters {
  std::string name{};
  double capacity_j_k = 0;
  double film_w_k = 0;  // h x area
  int air = kRoom;      // node the film leads to
  double expansion_per_k = 0;
};

struct LinkParameters {
  std::string name{};
  int from = 0, to = 0;  // node indices, or kRoom
  double conductance_w_k = 0;
};

struct AxisParameters {
  double min_mm = 0, max_mm = 0, scale_resolution_nm = 0, scale_error_ppm = 0, scale_noise_nm = 0;
  double velocity_mm_s = 0, acceleration_mm_s2 = 0, start_delay_s = 0;
  double resonance_hz = 0, damping = 0, ring_nm_per_mm_s2 = 0, window_nm = 0, window_s = 0;
  double hold_min_nm = 0, hold_max_nm = 0, hold_wander_nm = 0, hold_wander_s = 0,
         hold_jitter_nm = 0;
  double reference_s = 0, reference_repeatability_nm = 0, reference_offset_mm = 0;
  double stiffness_n_mm = 0, motor_constant_n_sqrtw = 0, moving_mass_kg = 0;
  int motor_part = 0;
};

struct SetPointStep {
  double hours = 0, degc = 0;
};

struct RoomParameters {
  std::vector<SetPointStep> schedule{};
  double ac_off_hours = 0;  // from then on the air conditioning is off
  double set_point_degc = 0, balance_degc = 0, ac_w_k = 0, wall_w_k = 0, air_j_k = 0, mass_j_k = 0,
         air_mass_w_k = 0;
  double cycle_s = 0, cycle_spread = 0, cycle_w = 0, wander_w = 0, wander_s = 0;
  double turbulence_k = 0, turbulence_s = 0;
  double pressure_hpa = 0, pressure_wander_hpa = 0, pressure_wander_h = 0;
  double humidity_pct = 0, humidity_wander_pct = 0, humidity_wander_h = 0;
};

struct InterferometerParameters {
  double sign = 1;            // of what is shown: + when the mirror goes away from the head
  double hidden_path_mm = 0;  // air that nobody typed in
  double dead_path_mm = 0, sample_rate_hz = 0, resolution_nm = 0, wavelength_nm = 0;
  double vibration_nm = 0, vibration_s = 0, instability_nm = 0, instability_s = 0;
  double beam_turbulence_k = 0;
  int air_part = 0;
  double air_probe_s = 0, air_probe_noise_k = 0, air_probe_resolution_k = 0, air_probe_period_s = 0;
  double level_pct = 0;
  double disturbances_per_hour = 0, disturbance_nm = 0, disturbance_min_s = 0,
         disturbance_max_s = 0;
};

struct StabiliserParameters {
  int part = 0, sink_part = 0;
  double set_point_degc = 0;
  Plant::StabiliserMode mode = Plant::StabiliserMode::automatic;
  double seebeck_v_k = 0, resistance_ohm = 0, conductance_w_k = 0, current_limit_a = 0;
  double heat_band_k = 0, cool_band_k = 0, integral_s = 0, derivative_s = 0;
  double sensor_s = 0, sensor_noise_k = 0;
  double sensor_drift_k = 0, sensor_drift_s = 0;  // standard deviation, correlation time
  double process_resolution_k = 0;
};

struct ThermometerParameters {
  std::string name{};
  int input = 0;
  std::vector<int> parts{};  // plain mean
  double lag_s = 0, stem = 0;
  double r0_ohm = 0, a_per_k = 0, b_per_k2 = 0, certificate_r0_ohm = 0;
};

// A sensor whose output is a voltage at an input of the scanner.
struct VoltageParameters {
  enum class Sees {
    column,  // a column of the truth
    height,  // of the plate at a place, along z, mm
    motor,   // force of an axis' motor with its dry friction, N
  };
  std::string name{};
  int input = 0;
  // V per unit of what it sees; is_sine: at a sine of 1. Never beyond +-limit_v.
  double volt_per_unit = 0, zero_v = 0, noise_v = 0, limit_v = 0;
  Sees sees = Sees::column;
  std::string column{};  // also of a motor: the force that it holds up by load_share
  bool is_sine = false;
  double x_mm = 0, y_mm = 0;
  int axis = 0;
  double stiffness_n_mm = 0, friction_n = 0, travel_mm = 0, load_share = 0;
};

// What every simulated cell has, whatever its robot.
struct CellParameters {
  double reference_degc = 0, start_hours_before = 0;
  double step_s = 0.1;                  // of everything that has a memory
  std::vector<PartParameters> parts{};  // index = node
  std::vector<LinkParameters> links{};
  std::vector<AxisParameters> axes{};
  RoomParameters room;
  std::vector<InterferometerParameters> interferometers{};
  std::vector<StabiliserParameters> stabilisers{};
  double scanner_noise_ohm = 0, scanner_resolution_ohm = 0;
  std::vector<ThermometerParameters> thermometers{};
  std::vector<VoltageParameters> voltages{};  // none by default
  std::vector<Hidden> hidden{};               // nothing by default
  int box_air_part = kRoom;       // air of a box that can be opened; kRoom: there is none
  double box_open_flow_m3_h = 0;  // exchanged with the room while it is open
};

}  // namespace driftwise::simulated
