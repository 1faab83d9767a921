#include "tests/hidden_effects/hidden_world.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

namespace driftwise::hidden {
namespace {

constexpr double kPi = std::numbers::pi;

struct Path {
  std::vector<double> time_s, x_mm, dwell_s;
  std::vector<bool> calibration;
};

Path make_path(const World& world, std::mt19937_64& random) {
  std::uniform_real_distribution<double> jitter(-1.5, 1.5);
  Path path;
  double time = 0;
  for (int pass = 0; pass < world.passes; ++pass)
    for (int k = 0; k < 18; ++k) {
      path.time_s.push_back(time);
      path.x_mm.push_back(k == 0 ? 0.0 : -4.0 + 0.5 * (k - 1));
      path.calibration.push_back(k == 0 || k % 2 == 1);
      path.dwell_s.push_back(10.2 + jitter(random));
      time += world.step_s + jitter(random);
    }
  return path;
}

// Every second from 0 to the end: a room that drifts and swings, and sensors behind bodies of
// different mass.
struct Weather {
  std::vector<double> room;
  std::vector<std::vector<double>> sensor;  // [sensor][second]
};

Weather make_weather(const World& world, double end_s, std::mt19937_64& random) {
  std::normal_distribution<double> normal(0, 1);
  const auto seconds = static_cast<std::size_t>(end_s) + 2;
  Weather weather;
  double slow = 20.5, swing = 0;
  const double phase = kPi * normal(random), period = 2400 + 600 * normal(random);
  std::vector<double> body(static_cast<std::size_t>(world.sensors), 20.5), second_body = body;
  weather.sensor.resize(body.size());
  for (std::size_t s = 0; s < seconds; ++s) {
    slow += (21.5 - slow) / 20000 + 0.0012 * normal(random);
    swing = 0.12 * std::sin(2 * kPi * static_cast<double>(s) / period + phase);
    weather.room.push_back(slow + swing);
    for (std::size_t i = 0; i < body.size(); ++i) {
      const double mass = 300 * std::pow(1.7, static_cast<double>(i));
      body[i] += (weather.room.back() - body[i]) / mass;
      second_body[i] += (body[i] - second_body[i]) / (0.4 * mass);
      weather.sensor[i].push_back(second_body[i]);
    }
  }
  return weather;
}

double interpolated(const std::vector<double>& by_second, double time) {
  const auto at = static_cast<std::size_t>(time);
  const double share = time - static_cast<double>(at);
  return by_second[at] * (1 - share) + by_second[at + 1] * share;
}

// What is hidden, of any size: make() scales it.
std::vector<double> shape_of(const Hidden& hidden, const Path& path, const Weather& weather,
                             const std::vector<std::vector<double>>& read) {
  const std::size_t n = path.time_s.size();
  std::vector<double> v(n, 0);
  const std::string& cause = hidden.cause;
  if (cause == "thermal_lag") {
    std::vector<double> lagged{weather.sensor[2][0]};
    for (std::size_t s = 1; s < weather.sensor[2].size(); ++s)
      lagged.push_back(lagged.back() + (weather.sensor[2][s] - lagged.back()) / hidden.parameter);
    for (std::size_t i = 0; i < n; ++i) v[i] = interpolated(lagged, path.time_s[i]);
  } else if (cause == "thermal_expansion") {
    for (std::size_t i = 0; i < n; ++i) v[i] = path.x_mm[i] * (read[2][i] - read[2][0]);
  } else if (cause == "geometry_order") {
    for (std::size_t i = 0; i < n; ++i) v[i] = std::pow(path.x_mm[i] / 4, 3);
  } else if (cause == "backlash") {
    double block = 0, drive = 0;
    const double half = hidden.parameter * 1e-6 / 2;
    for (std::size_t i = 0; i < n; ++i) {
      const int pieces = 1000;
      const double from = drive, step = (path.x_mm[i] - from) / pieces;
      for (int k = 1; k <= pieces; ++k) {
        drive = from + k * step;
        if (block > drive + half) block = drive + half;
        if (block < drive - half) block = drive - half;
      }
      v[i] = block - drive;
    }
  } else if (cause == "creep") {
    std::vector<std::pair<double, double>> moves;
    double at = 0;
    for (std::size_t i = 0; i < n; ++i) {
      moves.emplace_back(path.time_s[i] - path.dwell_s[i], path.x_mm[i] - at);
      at = path.x_mm[i];
      for (const auto& [when, length] : moves)
        v[i] += length * std::exp(-(path.time_s[i] - when) / hidden.parameter);
    }
  } else if (cause == "self_heating") {
    // warm while it moves every point, cool in long rests: heat by seconds
    double heat = 0, at = 0, before = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double dt = std::max(path.time_s[i] - before, 1e-9);
      const double speed = std::abs(path.x_mm[i] - at) / dt;
      const int pieces = 200;
      for (int k = 0; k < pieces; ++k) heat += dt / pieces / hidden.parameter * (speed - heat);
      v[i] = heat;
      at = path.x_mm[i];
      before = path.time_s[i];
    }
  } else if (cause == "cyclic_error") {
    for (std::size_t i = 0; i < n; ++i)
      v[i] = std::sin(2 * kPi * path.x_mm[i] * 1e6 / hidden.parameter + 0.7);
  } else if (cause == "instrument_drift") {
    for (std::size_t i = 0; i < n; ++i) v[i] = path.time_s[i];
  } else if (cause == "step_change") {
    for (std::size_t i = 0; i < n; ++i) v[i] = path.time_s[i] < hidden.parameter ? 0 : 1;
  } else if (cause == "periodic_disturbance") {
    for (std::size_t i = 0; i < n; ++i)
      v[i] = std::sin(2 * kPi * path.time_s[i] / hidden.parameter + 0.3);
  } else if (cause == "uncatalogued") {
    // a kink where a cable begins to pull
    for (std::size_t i = 0; i < n; ++i)
      v[i] = std::max(0.0, path.x_mm[i] - 2.6) * (path.x_mm[i] > 2.6);
    for (std::size_t i = 0; i < n; ++i) v[i] += std::abs(std::fmod(path.x_mm[i] + 8.0, 2.0) - 1.0);
  } else {
    throw std::invalid_argument("nothing hides " + cause);
  }
  return v;
}

}  // namespace

std::vector<Hidden> hideable() {
  return {{"thermal_lag", 1500, 0},   {"thermal_expansion", 0, 0},
          {"geometry_order", 0, 0},   {"backlash", 80, 0},
          {"creep", 20, 0},           {"self_heating", 900, 0},
          {"cyclic_error", 2.3e6, 0}, {"instrument_drift", 0, 0},
          {"step_change", 7000, 0},   {"periodic_disturbance", 655, 0}};
}

HiddenData make(const World& world, const std::vector<Hidden>& hidden, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0, 1);
  const Path path = make_path(world, random);
  const Weather weather = make_weather(world, path.time_s.back(), random);
  const std::size_t n = path.time_s.size();

  std::vector<std::vector<double>> read;  // sensors, with 0.2 mK of noise
  for (const auto& sensor : weather.sensor) {
    std::vector<double> values;
    for (const double time : path.time_s)
      values.push_back(interpolated(sensor, time) + 2e-4 * normal(random));
    read.push_back(std::move(values));
  }
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < n; ++i)
    if (path.calibration[i]) rows.push_back(i);

  // noise: white, and slow with the given correlation between calibration rows
  std::vector<double> noise(n);
  const double rho = world.autocorrelation;
  const double tau = rho > 0 ? -world.step_s * 1.8 / std::log(rho) : 1;
  const double slow_sd = rho > 0 ? world.noise_nm * std::sqrt(world.slow_share) : 0;
  const double white_sd = std::sqrt(world.noise_nm * world.noise_nm - slow_sd * slow_sd);
  double slow = slow_sd * normal(random);
  for (std::size_t i = 0; i < n; ++i) {
    if (i > 0) {
      const double a = std::exp(-(path.time_s[i] - path.time_s[i - 1]) / tau);
      slow = a * slow + slow_sd * std::sqrt(1 - a * a) * normal(random);
    }
    noise[i] = slow + white_sd * normal(random);
  }

  // whitening by the covariance itself
  const auto m = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd covariance(m, m);
  for (Eigen::Index a = 0; a < m; ++a)
    for (Eigen::Index b = 0; b < m; ++b)
      covariance(a, b) = slow_sd * slow_sd *
                             std::exp(-std::abs(path.time_s[rows[static_cast<std::size_t>(a)]] -
                                                path.time_s[rows[static_cast<std::size_t>(b)]]) /
                                      tau) +
                         (a == b ? white_sd * white_sd : 0);
  const Eigen::LLT<Eigen::MatrixXd> cholesky(covariance);
  Eigen::MatrixXd base(m, 3 + world.sensors);
  for (Eigen::Index a = 0; a < m; ++a) {
    const std::size_t i = rows[static_cast<std::size_t>(a)];
    base(a, 0) = 1;
    base(a, 1) = path.x_mm[i];
    base(a, 2) = path.x_mm[i] * path.x_mm[i];
    for (int k = 0; k < world.sensors; ++k)
      base(a, 3 + k) = read[static_cast<std::size_t>(k)][i] - 21;
  }
  const Eigen::MatrixXd white_base = cholesky.matrixL().solve(base);
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(white_base);
  const Eigen::MatrixXd q = qr.householderQ() * Eigen::MatrixXd::Identity(m, base.cols());

  HiddenData made;
  made.effect_nm.assign(n, 0);
  for (const auto& one : hidden) {
    if (one.cause.empty()) continue;
    const auto shape = shape_of(one, path, weather, read);
    Eigen::VectorXd at(m);
    for (Eigen::Index a = 0; a < m; ++a) at[a] = shape[rows[static_cast<std::size_t>(a)]];
    Eigen::VectorXd white = cholesky.matrixL().solve(at);
    white -= q * (q.transpose() * white).eval();
    const double scale = std::sqrt(one.chi2) / white.norm();
    for (std::size_t i = 0; i < n; ++i) made.effect_nm[i] += scale * shape[i];
  }

  Dataset& data = made.data;
  data.rows = n;
  data.time_s = path.time_s;
  data.dwell_s = path.dwell_s;
  DatasetColumn q1{{"q1", "mm"}, {}}, x{{"x", "mm"}, {}};
  for (std::size_t i = 0; i < n; ++i) {
    data.set.push_back(path.calibration[i] ? PointSet::calibration : PointSet::validation);
    double thermal_nm = 0;
    for (std::size_t k = 0; k < read.size(); ++k)
      thermal_nm += (60 - 25 * static_cast<double>(k)) * (read[k][i] - 21);
    x.values.push_back(path.x_mm[i]);
    q1.values.push_back(path.x_mm[i] * 1.0003 + 2e-6 * path.x_mm[i] * path.x_mm[i] +
                        (thermal_nm + made.effect_nm[i] + noise[i]) * 1e-6);
  }
  data.columns = {std::move(q1), std::move(x)};
  for (int k = 0; k < world.sensors; ++k) {
    const int number = 5 + k;
    data.columns.push_back({{(number < 10 ? "t0" : "t") + std::to_string(number), "degC"},
                            std::move(read[static_cast<std::size_t>(k)])});
  }
  made.baseline = "q1 ~ x + x^2 + T";
  return made;
}

}  // namespace driftwise::hidden
