#include "tests/hidden_effects/foreign/hidden.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <stdexcept>

#include "tests/hidden_effects/foreign/constants.h"
#include "tests/hidden_effects/foreign/monomials.h"
#include "tests/hidden_effects/foreign/shapes.h"

namespace driftwise::foreign {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

[[noreturn]] void refuse(const std::string& why) { throw std::runtime_error(why); }

Errors on_motors(const Campaign& campaign, const VectorXd& shape, const VectorXd& weights) {
  Errors errors{campaign.no_motor_error(), campaign.no_pose_error(), {}};
  for (int i = 0; i < campaign.robot.axes; ++i) {
    errors.dq.col(i) = shape * weights[i];
  }
  return errors;
}

Errors on_pose(const Campaign& campaign, const VectorXd& shape, int coordinate) {
  Errors errors{campaign.no_motor_error(), campaign.no_pose_error(), {}};
  errors.dp.col(coordinate) = shape;
  return errors;
}

VectorXd at_zero_of(const Campaign& campaign, int coordinate, double error) {
  VectorXd errors = VectorXd::Zero(campaign.robot.axes);
  errors[coordinate] = error;
  return errors;
}

// Weights of a mechanism that acts on one motor or on all, in the unit of each motor.
VectorXd drawn_weights(const Campaign& campaign, Random& random) {
  VectorXd weights = VectorXd::Zero(campaign.robot.axes);
  const int only = random.below(campaign.robot.axes);
  const bool all = random.chance(0.4);
  for (int i = 0; i < campaign.robot.axes; ++i) {
    if (all || i == only) {
      const double share = i == only ? random.sign() : random.uniform(-1.0, 1.0);
      weights[i] =
          share * campaign.robot.sigma[i] / campaign.robot.half[i] * campaign.robot.motor_half[i];
    }
  }
  return weights;
}

void set_linear(Hidden& hidden, const Errors& unit) {
  hidden.errors = [unit](double amplitude) {
    return Errors{unit.dq * amplitude, unit.dp * amplitude, {}};
  };
}

// Largest extent of the machine: what expands and what carries a lever, mm.
double machine_mm(const Campaign& campaign) {
  double largest = 50.0;
  for (int j = 0; j < campaign.robot.axes; ++j) {
    if (!campaign.robot.pose_is_angle[j]) {
      largest = std::max(largest, 4.0 * campaign.robot.half[j]);
    }
  }
  return largest;
}

int a_length_coordinate(const Campaign& campaign, Random& random) {
  std::vector<int> lengths;
  for (int j = 0; j < campaign.robot.axes; ++j) {
    if (!campaign.robot.pose_is_angle[j]) {
      lengths.push_back(j);
    }
  }
  if (lengths.empty()) {
    refuse("no length coordinate");
  }
  return random.pick(lengths);
}

std::string motor_symbol(int motor) { return "q" + std::to_string(motor + 1); }

void geometry_order(Hidden& hidden, const Campaign& campaign, Random& random) {
  const int wanted = campaign.degree + 1;
  std::vector<std::vector<int>> candidates;
  for (const std::vector<int>& powers : monomials(campaign.robot.axes, wanted)) {
    int total = 0;
    for (const int power : powers) {
      total += power;
    }
    if (total == wanted) {
      candidates.push_back(powers);
    }
  }
  const std::vector<int> powers = random.pick(candidates);
  const int main =
      static_cast<int>(std::max_element(powers.begin(), powers.end()) - powers.begin());
  const MatrixXd u = campaign.clean_u();
  VectorXd shape(campaign.rows());
  for (int i = 0; i < campaign.rows(); ++i) {
    shape[i] = monomial_value(powers, u.row(i).transpose());
  }
  hidden.subject = campaign.robot.pose[static_cast<std::size_t>(main)];
  hidden.parameters["degree"] = wanted;
  for (std::size_t j = 0; j < powers.size(); ++j) {
    hidden.parameters["power_" + campaign.robot.pose[j]] = powers[j];
  }
  set_linear(hidden, on_motors(campaign, shape, drawn_weights(campaign, random)));
}

void thermal(Hidden& hidden, const Campaign& campaign, Random& random) {
  const int count = campaign.thermometer_count();
  const double duration_s = campaign.time_s[campaign.rows() - 1];
  if (hidden.cause == "thermal_offset") {
    const int sensor = count - 1;
    hidden.subject = thermometer_symbol(sensor);
    const VectorXd shape = campaign.body.col(sensor).array() - campaign.body(0, sensor);
    set_linear(hidden, on_motors(campaign, shape, drawn_weights(campaign, random)));
    return;
  }
  const int sensor = random.below(count);
  hidden.subject = thermometer_symbol(sensor);
  if (hidden.cause == "thermal_lag") {
    const double tau_s = random.log_uniform(duration_s / 40.0, duration_s / 2.5);
    hidden.parameters["tau_s"] = tau_s;
    const VectorXd shape = lag_shape(campaign, sensor, tau_s).array() - campaign.body(0, sensor);
    set_linear(hidden, on_motors(campaign, shape, drawn_weights(campaign, random)));
  } else if (hidden.cause == "thermal_rate") {
    const VectorXd shape = rate_shape(campaign, sensor, 0.5 * campaign.room.step_s + 30.0);
    set_linear(hidden, on_motors(campaign, shape, drawn_weights(campaign, random)));
  } else {  // thermal_expansion
    const int coordinate = a_length_coordinate(campaign, random);
    const MatrixXd u = campaign.clean_u();
    VectorXd shape(campaign.rows());
    for (int i = 0; i < campaign.rows(); ++i) {
      shape[i] = 1e-6 * campaign.robot.pose_value(coordinate, u(i, coordinate)) *
                 (campaign.body(i, sensor) - campaign.body(0, sensor));
    }
    hidden.amplitude_name = "ppm_per_K";
    hidden.largest = 40.0;
    VectorXd weights = VectorXd::Zero(campaign.robot.axes);
    weights[coordinate] = random.sign();
    hidden.parameters["coordinate"] = coordinate;
    set_linear(hidden, on_motors(campaign, shape, weights));
  }
}

void forces(Hidden& hidden, const Campaign& campaign, Random& random) {
  hidden.subject = "F";
  const VectorXd share = campaign.force_n / std::max(campaign.force_n.maxCoeff(), 1e-12);
  VectorXd shape = share;
  if (hidden.cause == "force_nonlinearity") {
    // Hertz: a ball on a flat approaches with the force to the power 2/3.
    shape = share.array().pow(2.0 / 3.0);
  } else if (hidden.cause == "force_position_coupling") {
    const int coordinate = random.below(campaign.robot.axes);
    shape = share.cwiseProduct(campaign.clean_u().col(coordinate));
    hidden.parameters["coordinate"] = coordinate;
  }
  set_linear(hidden, on_motors(campaign, shape, drawn_weights(campaign, random)));
}

void moving(Hidden& hidden, const Campaign& campaign, Random& random) {
  const int motor = random.below(campaign.robot.axes);
  hidden.subject = motor_symbol(motor);
  VectorXd weights = VectorXd::Zero(campaign.robot.axes);
  const double sigma_motor =
      campaign.robot.sigma[motor] / campaign.robot.half[motor] * campaign.robot.motor_half[motor];
  weights[motor] = random.sign() * sigma_motor;
  if (hidden.cause == "backlash") {
    hidden.amplitude_name = campaign.robot.motor_is_angle[motor] ? "width_arcsec" : "width_mm";
    hidden.start = 2.0 * sigma_motor;
    hidden.largest = 0.02 * campaign.robot.motor_half[motor];
    hidden.errors = [&campaign, motor](double width) {
      Errors errors{campaign.no_motor_error(), campaign.no_pose_error(), {}};
      errors.dq.col(motor) = play_shape(campaign, motor, width);
      return errors;
    };
  } else if (hidden.cause == "creep") {
    const double tau_s = random.log_uniform(3.0, 120.0);
    hidden.parameters["tau_s"] = tau_s;
    set_linear(hidden, on_motors(campaign, creep_shape(campaign, motor, tau_s), weights));
  } else {  // self_heating
    const double tau_s =
        random.log_uniform(300.0, std::max(600.0, campaign.time_s[campaign.rows() - 1] / 3.0));
    hidden.parameters["tau_s"] = tau_s;
    VectorXd shape = motor_heat_shape(campaign, motor, tau_s);
    set_linear(hidden, on_motors(campaign, shape / std::max(shape.maxCoeff(), 1e-12), weights));
  }
}

void cyclic(Hidden& hidden, const Campaign& campaign, Random& random) {
  const int j = random.below(campaign.robot.axes);
  const bool scale = random.chance(0.5) && campaign.robot.kind != "delta";
  const bool angle = scale ? campaign.robot.motor_is_angle[j] : campaign.robot.pose_is_angle[j];
  const double half = scale ? campaign.robot.motor_half[j] : campaign.robot.half[j];
  std::vector<double> fitting;
  for (const double period : periods(angle, scale)) {
    if (period > 8.0 * campaign.robot.sigma[j] && period < 0.7 * half) {
      fitting.push_back(period);
    }
  }
  if (fitting.empty()) {
    refuse("no period between the noise and the stroke");
  }
  const double period = random.pick(fitting);
  const double phase = random.uniform(0.0, 6.28);
  hidden.subject = scale ? motor_symbol(j) : campaign.robot.pose[static_cast<std::size_t>(j)];
  hidden.parameters[angle ? "period_arcsec" : "period_nm"] = angle ? period : period * 1e6;
  hidden.largest = 0.1 * period;
  hidden.amplitude_name = angle ? "amplitude_arcsec" : "amplitude_mm";
  hidden.start = campaign.robot.sigma[j];
  const MatrixXd u = campaign.clean_u();
  VectorXd shape(campaign.rows());
  for (int i = 0; i < campaign.rows(); ++i) {
    const double at = scale ? campaign.robot.motor_value(j, campaign.s(i, j))
                            : campaign.robot.pose_value(j, u(i, j));
    shape[i] = std::sin(2.0 * std::numbers::pi * at / period + phase);
  }
  if (scale) {
    VectorXd weights = VectorXd::Zero(campaign.robot.axes);
    weights[j] = 1.0;
    set_linear(hidden, on_motors(campaign, shape, weights));
  } else {
    hidden.at_zero = at_zero_of(campaign, j, std::sin(phase));
    set_linear(hidden, on_pose(campaign, shape, j));
  }
}

void instruments(Hidden& hidden, const Campaign& campaign, Random& random) {
  const double duration_s = campaign.time_s[campaign.rows() - 1];
  const std::string& cause = hidden.cause;
  const bool of_length =
      cause == "abbe_offset" || cause == "cosine_error" || cause == "refractive_index";
  const int j =
      of_length ? a_length_coordinate(campaign, random) : random.below(campaign.robot.axes);
  const double sigma = campaign.robot.sigma[j];
  hidden.subject = campaign.robot.pose[static_cast<std::size_t>(j)];
  if (cause == "abbe_offset") {
    const int direction = direction_of(hidden.subject);
    const int arm = (direction + 1 + random.below(2)) % 3;
    hidden.parameters["arm"] = arm;
    hidden.amplitude_name = "offset_mm";
    hidden.largest = 2.0 * machine_mm(campaign);
    set_linear(hidden, on_pose(campaign, abbe_shape(campaign, direction, arm), j));
  } else if (cause == "cosine_error") {
    const int direction = direction_of(hidden.subject);
    const int tilt = (direction + 1 + random.below(2)) % 3;
    const double way = random.sign();
    hidden.amplitude_name = "angle_arcsec";
    hidden.parameters["tilt"] = tilt;
    hidden.start = 500.0;
    hidden.largest = 3600.0;
    hidden.errors = [&campaign, j, tilt, way](double angle_arcsec) {
      return on_pose(campaign, cosine_shape(campaign, j, tilt, way * angle_arcsec * kRadPerArcsec),
                     j);
    };
  } else if (cause == "refractive_index") {
    hidden.amplitude_name = "dead_path_mm";
    hidden.largest = std::max(1500.0, machine_mm(campaign));
    set_linear(hidden, on_pose(campaign, 1e-6 * air_shape(campaign), j));
  } else if (cause == "instrument_drift") {
    hidden.at_zero = at_zero_of(campaign, j, sigma * campaign.time_s[0] / duration_s);
    set_linear(hidden, on_pose(campaign, sigma * campaign.time_s / duration_s, j));
  } else if (cause == "step_change") {
    const int row = campaign.calibration[static_cast<std::size_t>(
        static_cast<double>(campaign.calibration.size()) * random.uniform(0.15, 0.85))];
    VectorXd shape = VectorXd::Zero(campaign.rows());
    shape.tail(campaign.rows() - row).setConstant(sigma * random.sign());
    hidden.parameters["time_s"] = 0.5 * (campaign.time_s[row] + campaign.time_s[row - 1]);
    set_linear(hidden, on_pose(campaign, shape, j));
  } else if (cause == "periodic_disturbance") {
    const double step_s = duration_s / campaign.rows();
    const double period_s = random.log_uniform(6.0 * step_s, duration_s / 4.0);
    const double phase = random.uniform(0.0, 6.28);
    hidden.parameters["period_s"] = period_s;
    const VectorXd shape =
        (2.0 * std::numbers::pi / period_s * campaign.time_s.array() + phase).sin();
    hidden.at_zero = at_zero_of(campaign, j, sigma * shape[0]);
    set_linear(hidden, on_pose(campaign, sigma * shape, j));
  } else if (cause == "probe_hysteresis") {
    const double slide = random.uniform(0.005, 0.02);
    set_linear(hidden, on_pose(campaign, sigma * friction_shape(campaign, j, slide), j));
  } else if (cause == "outliers") {
    VectorXd shape = VectorXd::Zero(campaign.rows());
    const int count = 3 + random.below(4);
    for (int k = 0; k < count; ++k) {
      shape[random.pick(campaign.calibration)] = random.sign() * random.uniform(0.7, 1.3) * sigma;
    }
    hidden.parameters["count"] = static_cast<double>((shape.array() != 0.0).count());
    hidden.largest = 60.0;
    set_linear(hidden, on_pose(campaign, shape, j));
  } else {  // noise_change
    hidden.noise_axis = j;
    hidden.noise_from_row = campaign.calibration[static_cast<std::size_t>(
        static_cast<double>(campaign.calibration.size()) * random.uniform(0.3, 0.7))];
    hidden.parameters["time_s"] = campaign.time_s[hidden.noise_from_row];
    hidden.amplitude_name = "ratio";
    set_linear(hidden, Errors{campaign.no_motor_error(), campaign.no_pose_error(), {}});
  }
}

void sensor_fault(Hidden& hidden, const Campaign& campaign, Random& random) {
  // A sensor that the model leans on: the one of the largest effect.
  int sensor = -1;
  double largest = 0.0;
  for (const int k : campaign.offered) {
    const double span = campaign.body.col(k).maxCoeff() - campaign.body.col(k).minCoeff();
    const double effect = campaign.thermal.col(k).cwiseAbs().maxCoeff() * span;
    if (effect > largest) {
      largest = effect;
      sensor = k;
    }
  }
  if (sensor < 0) {
    refuse("no thermometer that acts");
  }
  hidden.subject = thermometer_symbol(sensor);
  const int row = campaign.calibration[static_cast<std::size_t>(
      static_cast<double>(campaign.calibration.size()) * random.uniform(0.2, 0.8))];
  hidden.parameters["time_s"] = campaign.time_s[row];
  const bool jump = random.chance(0.6);
  const double way = random.sign();
  hidden.amplitude_name = jump ? "jump_K" : "gain_error";
  hidden.parameters[jump ? "jumped" : "mis_scaled"] = 1.0;
  hidden.start = 0.2;
  hidden.largest = jump ? 5.0 : 3.0;
  hidden.errors = [&campaign, sensor, row, jump, way](double size) {
    Errors errors{campaign.no_motor_error(), campaign.no_pose_error(), campaign.read};
    for (int i = row; i < campaign.rows(); ++i) {
      errors.read(i, sensor) +=
          way * size * (jump ? 1.0 : campaign.read(i, sensor) - campaign.read(row, sensor));
    }
    return errors;
  };
}

}  // namespace

std::string thermometer_symbol(int k) {
  return std::string(k + 1 < 10 ? "t0" : "t") + std::to_string(k + 1);
}

const std::vector<std::string>& cause_ids() {
  static const std::vector<std::string> ids{"geometry_order",
                                            "thermal_offset",
                                            "thermal_lag",
                                            "thermal_rate",
                                            "thermal_expansion",
                                            "self_heating",
                                            "force_compliance",
                                            "force_nonlinearity",
                                            "force_position_coupling",
                                            "backlash",
                                            "creep",
                                            "cyclic_error",
                                            "abbe_offset",
                                            "cosine_error",
                                            "refractive_index",
                                            "instrument_drift",
                                            "step_change",
                                            "periodic_disturbance",
                                            "sensor_fault",
                                            "outliers",
                                            "noise_change",
                                            "probe_hysteresis",
                                            "activity_heating"};
  return ids;
}

bool needs_time(const std::string& cause) {
  static const std::set<std::string> timeless{
      "geometry_order",   "thermal_offset",     "thermal_expansion",
      "force_compliance", "force_nonlinearity", "force_position_coupling",
      "backlash",         "cyclic_error",       "abbe_offset",
      "cosine_error",     "refractive_index",   "outliers",
      "probe_hysteresis"};
  return timeless.count(cause) == 0;
}

Needs cause_needs(const std::string& cause) {
  Needs needs;
  needs.times = needs_time(cause);
  if (cause == "thermal_offset") {
    needs.thermometers = 2;
    needs.spare = 1;
  } else if (cause.rfind("thermal_", 0) == 0) {
    needs.thermometers = 1;
  } else if (cause == "sensor_fault") {
    needs.thermometers = 2;
  } else if (cause == "self_heating") {
    needs.unsensed_heat = true;
  } else if (cause == "activity_heating") {
    needs.unsensed_heat = true;
    needs.activity = true;
  } else if (cause == "force_compliance") {
    needs.force_left_out = true;
  } else if (cause.rfind("force_", 0) == 0) {
    needs.force = true;
  } else if (cause == "abbe_offset" || cause == "cosine_error") {
    needs.tilts = true;
  } else if (cause == "refractive_index") {
    needs.air = true;
  } else if (cause == "geometry_order") {
    needs.degree = 2;
  }
  return needs;
}

Hidden draw_cause(const std::string& cause, const Campaign& campaign, Random& random) {
  Hidden hidden;
  hidden.cause = cause;
  const Needs needs = cause_needs(cause);
  if ((needs.tilts && !campaign.has_tilts) || (needs.air && !campaign.has_air)) {
    refuse("the campaign has no channel for it");
  }
  if (cause == "geometry_order") {
    geometry_order(hidden, campaign, random);
  } else if (cause == "sensor_fault") {
    sensor_fault(hidden, campaign, random);
  } else if (cause.rfind("thermal_", 0) == 0) {
    thermal(hidden, campaign, random);
  } else if (cause.rfind("force_", 0) == 0) {
    forces(hidden, campaign, random);
  } else if (cause == "backlash" || cause == "creep" || cause == "self_heating") {
    moving(hidden, campaign, random);
  } else if (cause == "cyclic_error") {
    cyclic(hidden, campaign, random);
  } else if (cause == "activity_heating") {
    const double tau_s =
        random.log_uniform(300.0, std::max(600.0, campaign.time_s[campaign.rows() - 1] / 3.0));
    const double power = random.chance(0.5) ? 1.0 : 2.0;
    hidden.subject = "activity";
    hidden.parameters = {{"tau_s", tau_s}, {"power", power}};
    set_linear(hidden, on_motors(campaign, activity_heat_shape(campaign, tau_s, power),
                                 drawn_weights(campaign, random)));
  } else {
    instruments(hidden, campaign, random);
  }
  return hidden;
}

}  // namespace driftwise::foreign
