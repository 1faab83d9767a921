#include "tests/hidden_effects/shapes/hidden_world.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <random>

#include "tests/hidden_effects/shapes/hidden_shapes.h"

namespace driftwise::hidden {
namespace {

constexpr double kCalibrationSteps = 14.3 * 1.6;  // seconds between calibration rows, about
constexpr double kThermometerNoise_k = 2e-4;

struct Noise {
  double white_nm = 0;
  std::vector<std::pair<double, double>> slow;  // sd in nm, correlation time in s
};

Noise noise_of(const World& world) {
  if (!(world.autocorrelation > 0)) return {world.noise_nm, {}};
  const double tau_s = -kCalibrationSteps / std::log(world.autocorrelation);
  const double slow_nm = world.noise_nm * std::sqrt(world.slow_share);
  Noise noise{world.noise_nm * std::sqrt(1 - world.slow_share), {{slow_nm, tau_s}}};
  if (world.two_times)
    noise.slow = {{slow_nm * std::sqrt(0.5), tau_s}, {slow_nm * std::sqrt(0.5), 5 * tau_s}};
  return noise;
}

Eigen::VectorXd series_of(const Noise& noise, const std::vector<double>& time_s,
                          std::mt19937_64& random) {
  std::normal_distribution<double> normal(0, 1);
  Eigen::VectorXd series(static_cast<Eigen::Index>(time_s.size()));
  for (auto& value : series) value = noise.white_nm * normal(random);
  for (const auto& [sd, tau_s] : noise.slow) {
    double slow = sd * normal(random);
    for (std::size_t i = 0; i < time_s.size(); ++i) {
      if (i > 0) {
        const double a = std::exp(-(time_s[i] - time_s[i - 1]) / tau_s);
        slow = a * slow + sd * std::sqrt(1 - a * a) * normal(random);
      }
      series[static_cast<Eigen::Index>(i)] += slow;
    }
  }
  return series;
}

Eigen::MatrixXd covariance_of(const Noise& noise, const std::vector<double>& time_s,
                              const std::vector<std::size_t>& rows) {
  const auto m = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(m, m);
  for (Eigen::Index a = 0; a < m; ++a)
    for (Eigen::Index b = 0; b < m; ++b)
      for (const auto& [sd, tau_s] : noise.slow)
        covariance(a, b) += sd * sd *
                            std::exp(-std::abs(time_s[rows[static_cast<std::size_t>(a)]] -
                                               time_s[rows[static_cast<std::size_t>(b)]]) /
                                     tau_s);
  covariance.diagonal().array() += noise.white_nm * noise.white_nm;
  return covariance;
}

bool lacks(const std::string& less, const std::string& term) {
  return (less + " ").find(" - " + term + " ") != std::string::npos;
}

// The columns of the baseline, written out here once more: the truth needs them for its strength.
Eigen::MatrixXd baseline_columns(const Scene& scene, const std::vector<std::size_t>& rows,
                                 const std::string& less) {
  std::vector<Eigen::VectorXd> columns;
  const auto add = [&](const auto& value) {
    Eigen::VectorXd v(static_cast<Eigen::Index>(rows.size()));
    for (std::size_t a = 0; a < rows.size(); ++a) v[static_cast<Eigen::Index>(a)] = value(rows[a]);
    columns.push_back(std::move(v));
  };
  const auto& path = scene.path;
  const int axes = scene.outputs(), degree = axes == 1 ? 2 : 3;
  for (int i = 0; i <= degree; ++i)
    for (int j = 0; j <= (axes > 1 ? degree - i : 0); ++j)
      for (int k = 0; k <= (axes > 1 ? degree - i - j : 0); ++k)
        add([&](std::size_t row) {
          const auto& at = path.at_mm[row];
          return std::pow(at[0] / 2, i) * std::pow(at[1] / 2, j) * std::pow(at[2] / 2, k);
        });
  if (axes > 1)
    for (int p = 1; p <= 3; ++p)
      if (!lacks(less, p == 1 ? "F" : "F^" + std::to_string(p)))
        add([&](std::size_t row) { return std::pow(path.force_n[row], p); });
  for (std::size_t s = 0; s < scene.read_degc.size(); ++s) {
    const int number = scene.first_sensor + static_cast<int>(s);
    if (!lacks(less, (number < 10 ? "t0" : "t") + std::to_string(number)))
      add([&](std::size_t row) { return scene.read_degc[s][row] - 21; });
  }
  Eigen::MatrixXd result(static_cast<Eigen::Index>(rows.size()),
                         static_cast<Eigen::Index>(columns.size()));
  for (std::size_t j = 0; j < columns.size(); ++j)
    result.col(static_cast<Eigen::Index>(j)) = columns[j];
  return result;
}

// From a source of its own: with 0 everything else is drawn as it always was.
void stand_off(Path& path, double hold_nm, std::uint64_t seed) {
  std::mt19937_64 random(seed * 6151 + 7);
  std::uniform_real_distribution<double> off_mm(-hold_nm * 1e-6, hold_nm * 1e-6);
  for (auto& at : path.at_mm)
    for (double& one : at) one += off_mm(random);
}

Scene make_scene(const World& world, std::uint64_t seed, std::mt19937_64& random) {
  const Robot robot = world.robot;
  std::normal_distribution<double> normal(0, 1);
  Scene scene;
  scene.robot = robot;
  scene.path = make_path(robot, random);
  if (world.hold_nm > 0) stand_off(scene.path, world.hold_nm, seed);
  const bool linear = robot == Robot::linear_axis;
  scene.first_sensor = linear ? 1 : 4;
  scene.weather = make_weather(linear ? 10 : 7, scene.path.time_s.back(), random);
  for (const auto& sensor : scene.weather.sensor_degc) {
    std::vector<double> values;
    for (const double time : scene.path.time_s)
      values.push_back(at_time(sensor, time) + kThermometerNoise_k * normal(random));
    scene.read_degc.push_back(std::move(values));
  }
  scene.motor_from_pose << 0.8, 0.5, 0.33, -0.5, 0.84, 0.2, 0.1, -0.4, 0.91;
  if (linear) scene.motor_from_pose(0, 0) = 1.0003;
  std::array<double, 3> wander = {0, 0, 0};
  for (std::size_t i = 0; i < scene.path.rows(); ++i) {
    std::array<double, 3> tilt{};
    for (std::size_t k = 0; k < 3; ++k) {
      wander[k] = 0.95 * wander[k] + 0.3 * normal(random);
      tilt[k] = wander[k] + 0.4 * scene.path.at_mm[i][(k + 1) % 3] + 0.2 * normal(random);
    }
    scene.tilt_arcsec.push_back(tilt);
  }
  return scene;
}

void add_channel(Dataset& data, const std::string& symbol, const std::string& unit,
                 std::vector<double> values) {
  data.columns.push_back({{symbol, unit}, std::move(values)});
}

void spoil(const Hidden& fault, Scene& scene, HiddenData& made, Eigen::MatrixXd& noise,
           std::mt19937_64& random) {
  const std::size_t n = scene.path.rows();
  if (fault.cause == "sensor_fault") {
    auto& sensor = scene.read_degc[3];
    const int number = scene.first_sensor + 3;
    made.hidden.push_back({fault.cause, scene.path.time_s[2 * n / 3], 0,
                           (number < 10 ? "t0" : "t") + std::to_string(number)});
    for (std::size_t i = 2 * n / 3; i < n; ++i)
      sensor[i] = fault.parameter > 0 ? sensor[i] + fault.parameter : sensor[2 * n / 3];
  } else if (fault.cause == "outliers") {
    for (int k = 0; k < 5; ++k) {
      const auto row =
          std::uniform_int_distribution<std::size_t>(5, made.calibration.size() - 5)(random);
      noise(static_cast<Eigen::Index>(made.calibration[row]), 0) += k % 2 == 0 ? 120 : -150;
    }
    made.hidden.push_back({fault.cause, 5, 0, ""});
  } else if (fault.cause == "noise_change") {
    noise.bottomRows(static_cast<Eigen::Index>(n / 2)) *= fault.parameter;
    made.hidden.push_back({fault.cause, fault.parameter, 0, "q1"});
  }
}

bool is_fault(const std::string& cause) {
  return cause == "sensor_fault" || cause == "outliers" || cause == "noise_change";
}

}  // namespace

std::vector<Hidden> hideable(Robot robot, std::uint64_t seed) {
  std::mt19937_64 random(seed * 7919 + 13);
  const auto between = [&](double low, double high) {
    return low * std::pow(high / low, std::uniform_real_distribution<double>(0, 1)(random));
  };
  const bool linear = robot == Robot::linear_axis;
  std::vector<Hidden> all = {{"thermal_offset"},
                             {"thermal_lag", between(300, 2500)},
                             {"thermal_rate"},
                             {"thermal_expansion"},
                             {"geometry_order"},
                             {"backlash", between(40, 200)},
                             {"creep", between(8, 60)},
                             {"self_heating", between(300, 2000)},
                             {"cyclic_error", between(1.3e6, 3e6)},
                             {"abbe_offset"},
                             {"cosine_error"},
                             {"refractive_index"},
                             {"instrument_drift"},
                             {"step_change", between(2000, 12000)},
                             {"periodic_disturbance", between(80, 900)}};
  if (!linear)
    for (const char* cause : {"force_compliance", "force_nonlinearity", "force_position_coupling"})
      all.push_back({cause});
  return all;
}

std::vector<Hidden> faults() {
  return {{"sensor_fault", 0}, {"sensor_fault", 0.3}, {"outliers", 5}, {"noise_change", 2}};
}

std::vector<Hidden> uncatalogued() {
  return {{"uncatalogued:kink"},       {"uncatalogued:scale_drift"}, {"uncatalogued:burst"},
          {"uncatalogued:steps_in_x"}, {"uncatalogued:notch"},       {"uncatalogued:ring_down"},
          {"uncatalogued:chirp"},      {"uncatalogued:scale_step"},  {"uncatalogued:warm_stop"}};
}

HiddenData make(const World& world, const std::vector<Hidden>& hidden, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Scene scene = make_scene(world, seed, random);
  const auto& path = scene.path;
  const std::size_t n = path.rows();
  const auto outputs = static_cast<Eigen::Index>(scene.outputs());
  HiddenData made;
  for (std::size_t i = 0; i < n; ++i)
    if (path.calibration[i]) made.calibration.push_back(i);
  const Noise shape = noise_of(world);
  Eigen::MatrixXd noise(static_cast<Eigen::Index>(n), outputs);
  for (Eigen::Index o = 0; o < outputs; ++o) noise.col(o) = series_of(shape, path.time_s, random);
  made.covariance = covariance_of(shape, path.time_s, made.calibration);
  const Eigen::LLT<Eigen::MatrixXd> cholesky(made.covariance);

  std::vector<Shape> shapes;
  std::string less;
  for (const auto& one : hidden) {
    if (one.cause.empty() || is_fault(one.cause)) continue;
    shapes.push_back(shape_of(one, scene, random));
    less += shapes.back().baseline_less;
    made.hidden.push_back({one.cause, one.parameter, one.chi2, shapes.back().subject});
  }
  // whitening by the covariance itself
  const Eigen::MatrixXd white_base =
      cholesky.matrixL().solve(baseline_columns(scene, made.calibration, less));
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(white_base);
  const Eigen::MatrixXd basis =
      Eigen::MatrixXd(qr.householderQ()).leftCols(std::min(qr.rank(), white_base.cols()));
  made.effect_nm = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(n), outputs);
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    Eigen::MatrixXd at(static_cast<Eigen::Index>(made.calibration.size()), outputs);
    for (std::size_t a = 0; a < made.calibration.size(); ++a)
      at.row(static_cast<Eigen::Index>(a)) =
          shapes[k].values.row(static_cast<Eigen::Index>(made.calibration[a]));
    Eigen::MatrixXd white = cholesky.matrixL().solve(at);
    white -= basis * (basis.transpose() * white).eval();
    made.effect_nm += std::sqrt(made.hidden[k].chi2) / white.norm() * shapes[k].values;
  }
  for (const auto& one : hidden)
    if (is_fault(one.cause)) spoil(one, scene, made, noise, random);

  // What the noise of the motors' readings is in the pose: through the geometry.
  Eigen::MatrixXd pose_noise = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(n), 3);
  if (world.noise_in_pose) {
    const Eigen::MatrixXd geometry = scene.motor_from_pose.topLeftCorner(outputs, outputs);
    pose_noise.leftCols(outputs) = -noise * geometry.inverse().transpose();
    noise.setZero();
  }
  Dataset& data = made.data;
  data.rows = n;
  data.time_s = path.time_s;
  data.dwell_s = path.dwell_s;
  for (std::size_t i = 0; i < n; ++i)
    data.set.push_back(path.calibration[i] ? PointSet::calibration : PointSet::validation);
  for (Eigen::Index o = 0; o < outputs; ++o) {
    std::vector<double> q;
    for (std::size_t i = 0; i < n; ++i) {
      const auto& at = path.at_mm[i];
      double mm = 2e-6 * at[0] * at[0] + (outputs > 1 ? 3e-6 * at[1] * at[2] : 0);
      for (std::size_t k = 0; k < 3; ++k)
        mm += scene.motor_from_pose(o, static_cast<Eigen::Index>(k)) *
              (outputs > 1 || k == 0 ? at[k] : 0);
      double nm = 0;
      for (std::size_t s = 0; s < scene.read_degc.size(); ++s)
        nm += (60 - 15 * static_cast<double>(s) + 10 * static_cast<double>(o)) *
              (at_time(scene.weather.sensor_degc[s], path.time_s[i]) - 21) *
              (lacks(less, (scene.first_sensor + static_cast<int>(s) < 10 ? "t0" : "t") +
                               std::to_string(scene.first_sensor + static_cast<int>(s)))
                   ? 0
                   : 1);
      if (outputs > 1 && !lacks(less, "F")) nm += 40 * path.force_n[i];
      if (outputs > 1 && !lacks(less, "F^2")) nm += 5 * path.force_n[i] * path.force_n[i];
      const auto row = static_cast<Eigen::Index>(i);
      q.push_back(mm + (nm + made.effect_nm(row, o) + noise(row, o)) * 1e-6);
    }
    add_channel(data, "q" + std::to_string(o + 1), "mm", std::move(q));
  }
  for (std::size_t k = 0; k < static_cast<std::size_t>(outputs); ++k) {
    std::vector<double> x;
    for (std::size_t i = 0; i < n; ++i)
      x.push_back(path.at_mm[i][k] +
                  1e-6 * pose_noise(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)));
    add_channel(data, std::string(1, static_cast<char>('x' + k)), "mm", std::move(x));
  }
  for (std::size_t k = 0; k < 3; ++k) {
    std::vector<double> tilt;
    for (const auto& at : scene.tilt_arcsec) tilt.push_back(at[k]);
    add_channel(data, std::string("r") + static_cast<char>('x' + k), "arcsec", std::move(tilt));
  }
  if (outputs > 1) add_channel(data, "force", "N", path.force_n);
  for (std::size_t s = 0; s < scene.read_degc.size(); ++s) {
    const int number = scene.first_sensor + static_cast<int>(s);
    add_channel(data, (number < 10 ? "t0" : "t") + std::to_string(number), "degC",
                scene.read_degc[s]);
  }
  const auto sampled = [&](const std::vector<double>& by_second) {
    std::vector<double> values;
    for (const double time : path.time_s) values.push_back(at_time(by_second, time));
    return values;
  };
  add_channel(data, "air", "degC", sampled(scene.weather.air_degc));
  add_channel(data, "pressure", "hPa", sampled(scene.weather.pressure_hpa));
  add_channel(data, "humidity", "pct", sampled(scene.weather.humidity_pct));
  made.baseline =
      (outputs == 1 ? "q1 ~ x + x^2 + T" : "q ~ poly(x, y, z, 3) + F + F^2 + F^3 + T") + less;
  return made;
}

}  // namespace driftwise::hidden
