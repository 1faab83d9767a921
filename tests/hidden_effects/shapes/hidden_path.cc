#include "tests/hidden_effects/shapes/hidden_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace driftwise::hidden {
namespace {

constexpr double kStepS = 14.3, kJitterS = 1.5;

void visit(Path& path, double& time, std::array<double, 3> at, double force, bool calibration,
           std::mt19937_64& random) {
  std::uniform_real_distribution<double> jitter(-kJitterS, kJitterS), dwell(6, 12);
  path.time_s.push_back(time);
  path.at_mm.push_back(at);
  path.force_n.push_back(force);
  path.calibration.push_back(calibration);
  path.dwell_s.push_back(dwell(random));
  time += kStepS + jitter(random);
}

Path linear_path(std::mt19937_64& random) {
  Path path;
  double time = 0;
  for (int pass = 0; pass < 56; ++pass)
    for (int k = 0; k < 18; ++k) {
      const int place = pass % 2 == 0 ? k - 1 : 17 - k;
      const double x = k == 0 ? 0.0 : -4.0 + 0.5 * place;
      const bool calibration = k == 0 || (k + pass / 2) % 2 == 1;  // every place in both sets
      visit(path, time, {x, 0, 0}, 0, calibration, random);
    }
  return path;
}

Path cube_path(std::mt19937_64& random) {
  Path path;
  double time = 0;
  std::uniform_int_distribution<int> any(0, 5), axis(0, 2), coin(0, 1);
  const std::array<double, 8> loads = {0, 1.4, 0.5, 2.3, 0.9, 0, 1.9, 0.2};
  for (const double force : loads)
    for (int k = 0; k < 132;) {
      const int along = axis(random);
      const bool up = coin(random) == 1;
      std::array<double, 3> at = {0.5 * any(random), 0.5 * any(random), 0.5 * any(random)};
      for (int j = 0; j < 7 && k < 132; ++j, ++k) {  // six places and back to zero
        at[static_cast<std::size_t>(along)] = 0.5 * (up ? j : 5 - j);
        const bool judged = j == 2 || j == 4;
        auto here = at;
        if (judged)
          for (double& one : here) one = std::min(one + 0.25, 2.5);
        if (j == 6) here = {0, 0, 0};
        visit(path, time, here, force, !judged, random);
      }
    }
  return path;
}

}  // namespace

Path make_path(Robot robot, std::mt19937_64& random) {
  return robot == Robot::linear_axis ? linear_path(random) : cube_path(random);
}

Weather make_weather(int sensors, double end_s, std::mt19937_64& random) {
  std::normal_distribution<double> normal(0, 1);
  const auto seconds = static_cast<std::size_t>(end_s) + 2;
  Weather weather;
  double slow = 20.5, pressure = 0, humidity = 0;
  const double phase = std::numbers::pi * normal(random), period = 2400 + 300 * normal(random);
  std::vector<double> body(static_cast<std::size_t>(sensors), 20.5), second = body,
                                                                     own(body.size());
  weather.sensor_degc.resize(body.size());
  for (std::size_t s = 0; s < seconds; ++s) {
    slow += (21.5 - slow) / 20000 + 0.0012 * normal(random);
    pressure += -pressure / 8000 + 0.02 * normal(random);
    humidity += -humidity / 6000 + 0.02 * normal(random);
    const double room =
        slow + 0.12 * std::sin(2 * std::numbers::pi * static_cast<double>(s) / period + phase);
    weather.air_degc.push_back(room + 0.3);
    weather.pressure_hpa.push_back(1013 + pressure);
    weather.humidity_pct.push_back(45 + humidity);
    for (std::size_t i = 0; i < body.size(); ++i) {
      const double mass = 300 * std::pow(1.4, static_cast<double>(i));
      own[i] += -own[i] / 3000 + 0.0008 * normal(random);  // a draught that is this sensor's alone
      body[i] += (room + own[i] - body[i]) / mass;
      second[i] += (body[i] - second[i]) / (0.4 * mass);
      weather.sensor_degc[i].push_back(second[i]);
    }
  }
  return weather;
}

double at_time(const std::vector<double>& by_second, double time_s) {
  const auto at = static_cast<std::size_t>(time_s);
  const double share = time_s - static_cast<double>(at);
  return by_second[at] * (1 - share) + by_second[at + 1] * share;
}

}  // namespace driftwise::hidden
