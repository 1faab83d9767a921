#include "tests/hidden_effects/shapes/hidden_shapes.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <stdexcept>

namespace driftwise::hidden {
namespace {

constexpr double kPi = std::numbers::pi;
using Column = Eigen::VectorXd;

Eigen::Index rows_of(const Scene& scene) { return static_cast<Eigen::Index>(scene.path.rows()); }

Column by_row(const Scene& scene, const std::function<double(std::size_t)>& value) {
  Column v(rows_of(scene));
  for (std::size_t i = 0; i < scene.path.rows(); ++i) v[static_cast<Eigen::Index>(i)] = value(i);
  return v;
}

// A motor coordinate in mm at each row.
std::vector<double> motor(const Scene& scene, std::size_t which) {
  std::vector<double> q;
  for (const auto& at : scene.path.at_mm) {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k)
      sum += scene.motor_from_pose(static_cast<Eigen::Index>(which), static_cast<Eigen::Index>(k)) *
             at[k];
    q.push_back(sum);
  }
  return q;
}

Column play(const std::vector<double>& q, double width_nm) {
  Column v(static_cast<Eigen::Index>(q.size()));
  double block = q.front(), drive = q.front();
  const double half = width_nm * 1e-6 / 2;
  for (std::size_t i = 0; i < q.size(); ++i) {
    constexpr int kPieces = 400;
    const double from = drive, step = (q[i] - from) / kPieces;
    for (int k = 1; k <= kPieces; ++k) {
      drive = from + k * step;
      if (block > drive + half) block = drive + half;
      if (block < drive - half) block = drive - half;
    }
    v[static_cast<Eigen::Index>(i)] = block - drive;
  }
  return v;
}

Column creep(const Path& path, const std::vector<double>& q, double tau_s) {
  Column v = Column::Zero(static_cast<Eigen::Index>(q.size()));
  std::vector<std::pair<double, double>> moves;
  for (std::size_t i = 0; i < q.size(); ++i) {
    if (i > 0) moves.emplace_back(path.time_s[i] - path.dwell_s[i], q[i] - q[i - 1]);
    for (const auto& [when, length] : moves)
      v[static_cast<Eigen::Index>(i)] += length * std::exp(-(path.time_s[i] - when) / tau_s);
  }
  return v;
}

Column heat(const Path& path, const std::vector<double>& q, double tau_s) {
  Column v(static_cast<Eigen::Index>(q.size()));
  double warm = 0;
  for (std::size_t i = 0; i < q.size(); ++i) {
    const double dt = i == 0 ? 0 : path.time_s[i] - path.time_s[i - 1];
    const double speed = i == 0 ? 0 : std::abs(q[i] - q[i - 1]) / dt;
    constexpr int kPieces = 200;
    for (int k = 0; k < kPieces; ++k) warm += dt / kPieces / tau_s * (speed - warm);
    v[static_cast<Eigen::Index>(i)] = warm;
  }
  return v;
}

Column lagged(const Scene& scene, std::size_t sensor, double tau_s) {
  const auto& by_second = scene.weather.sensor_degc[sensor];
  std::vector<double> behind{by_second.front()};
  for (std::size_t s = 1; s < by_second.size(); ++s)
    behind.push_back(behind.back() + (by_second[s] - behind.back()) / tau_s);
  return by_row(scene, [&](std::size_t i) { return at_time(behind, scene.path.time_s[i]); });
}

Column uncatalogued_shape(const std::string& kind, const Scene& scene) {
  const auto& path = scene.path;
  const auto x = [&](std::size_t i) { return path.at_mm[i][0]; };
  const double end_s = path.time_s.back();
  const double top = scene.robot == Robot::linear_axis ? 4 : 2.5;
  if (kind == "kink")  // where a cable begins to pull
    return by_row(scene, [&](std::size_t i) {
      return std::max(0.0, x(i) - 0.65 * top) + 0.4 * std::abs(std::fmod(x(i) + 8.0, 2.0) - 1.0);
    });
  if (kind == "scale_drift")  // an axis that grows with time, whatever the thermometers say
    return by_row(scene, [&](std::size_t i) {
      return x(i) * std::sin(3 * path.time_s[i] / end_s) * path.time_s[i] / end_s;
    });
  if (kind == "burst")  // a wobble in one stretch of time
    return by_row(scene, [&](std::size_t i) {
      const double u = (path.time_s[i] / end_s - 0.55) / 0.04;
      return std::exp(-u * u);
    });
  if (kind == "steps_in_x")  // a staircase
    return by_row(scene, [&](std::size_t i) { return std::floor(std::pow(std::abs(x(i)), 1.5)); });
  if (kind == "notch")  // a particle on the guide
    return by_row(scene, [&](std::size_t i) {
      const double u = (x(i) - 0.4 * top) / (0.17 * top);
      return std::exp(-u * u);
    });
  if (kind == "ring_down")  // a table that is read before it is at rest, whatever moved
    return by_row(scene, [&](std::size_t i) { return std::exp(-path.dwell_s[i] / 2); });
  if (kind == "chirp")  // a pump that slows down: 150 to 450 s
    return by_row(scene, [&](std::size_t i) {
      const double u = path.time_s[i] / end_s;
      return std::sin(kPi * end_s / 150 * std::log1p(2 * u));
    });
  if (kind == "scale_step")  // a beam knocked to another angle
    return by_row(scene, [&](std::size_t i) { return path.time_s[i] < 0.4 * end_s ? 0 : x(i); });
  if (kind == "warm_stop") {  // a part that touches its neighbour when it is warm
    auto read = scene.read_degc[3];
    std::ranges::nth_element(read, read.begin() + static_cast<std::ptrdiff_t>(read.size() / 2));
    const double touches_degc = read[read.size() / 2];
    return by_row(
        scene, [&](std::size_t i) { return std::max(0.0, scene.read_degc[3][i] - touches_degc); });
  }
  throw std::invalid_argument("nothing hides uncatalogued:" + kind);
}

std::string sensor_name(const Scene& scene, std::size_t sensor) {
  const int number = scene.first_sensor + static_cast<int>(sensor);
  return (number < 10 ? "t0" : "t") + std::to_string(number);
}

}  // namespace

Shape shape_of(const Hidden& hidden, const Scene& scene, std::mt19937_64& random) {
  const auto& path = scene.path;
  const auto outputs = static_cast<Eigen::Index>(scene.outputs());
  std::normal_distribution<double> normal(0, 1);
  Eigen::RowVectorXd anywhere(outputs);  // how much each output has of what moves the robot
  for (Eigen::Index o = 0; o < outputs; ++o) anywhere[o] = normal(random);
  anywhere.normalize();
  const auto axis = static_cast<std::size_t>(
      std::uniform_int_distribution<int>(0, static_cast<int>(outputs) - 1)(random));
  const std::string axis_name(1, static_cast<char>('x' + axis));
  const std::string motor_name = "q" + std::to_string(axis + 1);
  Eigen::RowVectorXd one = Eigen::RowVectorXd::Zero(outputs);
  one[static_cast<Eigen::Index>(axis)] = 1;
  // What is wrong with a pose axis shows in the motors through the geometry.
  const Eigen::RowVectorXd through =
      scene.motor_from_pose.col(static_cast<Eigen::Index>(axis)).head(outputs).transpose();
  const auto sensor = static_cast<std::size_t>(
      std::uniform_int_distribution<int>(0, static_cast<int>(scene.read_degc.size()) - 1)(random));
  const auto x = [&](std::size_t i) { return path.at_mm[i][axis]; };
  const auto q = motor(scene, axis);
  const std::string& cause = hidden.cause;
  const std::string name = sensor_name(scene, sensor);
  const auto& read = scene.read_degc[sensor];
  const bool linear = scene.robot == Robot::linear_axis;

  if (cause == "thermal_offset")
    return {by_row(scene, [&](std::size_t i) { return read[i]; }) * anywhere, name, " - " + name};
  if (cause == "thermal_lag") return {lagged(scene, sensor, hidden.parameter) * anywhere, name, ""};
  if (cause == "thermal_rate")
    return {by_row(scene,
                   [&](std::size_t i) {
                     // over a minute: what bends is no thinner than heat travels in that time
                     const auto& s = scene.weather.sensor_degc[sensor];
                     const double at = path.time_s[i];
                     return at_time(s, at) - at_time(s, std::max(at - 60, 0.0));
                   }) *
                anywhere,
            name, ""};
  if (cause == "thermal_expansion")
    return {by_row(scene, [&](std::size_t i) { return x(i) * (read[i] - read[0]); }) * through,
            name, ""};
  if (cause == "geometry_order")
    return {
        by_row(scene, [&](std::size_t i) { return std::pow(x(i) / 4, linear ? 3 : 4); }) * anywhere,
        axis_name, ""};
  if (cause == "force_compliance")
    return {by_row(scene, [&](std::size_t i) { return path.force_n[i]; }) * anywhere, "F",
            " - F - F^2 - F^3"};
  if (cause == "force_nonlinearity")
    return {by_row(scene, [&](std::size_t i) { return std::pow(path.force_n[i], 2); }) * anywhere,
            "F", " - F^2 - F^3"};
  if (cause == "force_position_coupling")
    return {by_row(scene, [&](std::size_t i) { return x(i) * path.force_n[i]; }) * anywhere, "F",
            ""};
  if (cause == "backlash") return {play(q, hidden.parameter) * one, motor_name, ""};
  if (cause == "creep") return {creep(path, q, hidden.parameter) * one, motor_name, ""};
  if (cause == "self_heating") return {heat(path, q, hidden.parameter) * anywhere, motor_name, ""};
  if (cause == "cyclic_error")
    return {by_row(scene,
                   [&](std::size_t i) {
                     return std::sin(2 * kPi * x(i) * 1e6 / hidden.parameter + 0.7);
                   }) *
                through,
            axis_name, ""};
  if (cause == "abbe_offset") {
    const std::size_t tilt = axis == 0 ? 1 : 0;  // one that the axis has a lever to
    return {by_row(scene, [&](std::size_t i) { return scene.tilt_arcsec[i][tilt]; }) * through,
            axis_name, ""};
  }
  if (cause == "cosine_error") {
    const std::size_t tilt = axis == 0 ? 1 : 0;
    return {by_row(scene,
                   [&](std::size_t i) {
                     return (x(i) + 1) * std::pow(1e-3 + scene.tilt_arcsec[i][tilt] * 4.848e-6, 2);
                   }) *
                through,
            axis_name, ""};
  }
  if (cause == "refractive_index")
    return {by_row(scene,
                   [&](std::size_t i) {
                     // sensitivities of air at 20 degC, 1013 hPa, 50 %: ppm per K, hPa, %
                     const double t = path.time_s[i];
                     return -0.93 * at_time(scene.weather.air_degc, t) +
                            0.268 * at_time(scene.weather.pressure_hpa, t) -
                            0.0085 * at_time(scene.weather.humidity_pct, t);
                   }) *
                through,
            axis_name, ""};
  if (cause == "instrument_drift")
    return {by_row(scene, [&](std::size_t i) { return path.time_s[i]; }) * through, axis_name, ""};
  if (cause == "step_change")
    return {by_row(scene,
                   [&](std::size_t i) { return path.time_s[i] < hidden.parameter ? 0.0 : 1.0; }) *
                through,
            axis_name, ""};
  if (cause == "periodic_disturbance")
    return {by_row(scene,
                   [&](std::size_t i) {
                     return std::sin(2 * kPi * path.time_s[i] / hidden.parameter + 0.3);
                   }) *
                through,
            axis_name, ""};
  if (cause.starts_with("uncatalogued:"))
    return {uncatalogued_shape(cause.substr(13), scene) * anywhere, "", ""};
  throw std::invalid_argument("nothing hides " + cause);
}

}  // namespace driftwise::hidden
