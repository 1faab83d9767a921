#include "tests/hidden_effects/foreign/room.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace driftwise::foreign {
namespace {

using Eigen::VectorXd;

struct Weather {
  double ramp_k_per_h;
  double day_k;
  double day_phase;
  double conditioner_k;
  double conditioner_s;
  std::vector<double> door_s;
  std::vector<double> door_k;
};

double air_at(const Weather& weather, double time_s) {
  const double turn = 2.0 * std::numbers::pi;
  double air = 20.5 + weather.ramp_k_per_h * time_s / 3600.0 +
               weather.day_k * std::sin(turn * time_s / 86400.0 + weather.day_phase) +
               weather.conditioner_k * std::sin(turn * time_s / weather.conditioner_s);
  for (std::size_t k = 0; k < weather.door_s.size(); ++k) {
    const double since = time_s - weather.door_s[k];
    if (since > 0.0) {
      air += weather.door_k[k] * (1.0 - std::exp(-since / 300.0)) * std::exp(-since / 5000.0);
    }
  }
  return air;
}

Weather draw_weather(double duration_s, Random& random) {
  Weather weather{};
  weather.ramp_k_per_h =
      random.sign() * random.uniform(0.2, 1.5) / std::max(1.0, duration_s / 7200.0);
  weather.day_k = random.uniform(0.2, 1.0);
  weather.day_phase = random.uniform(0.0, 6.28);
  weather.conditioner_k = random.uniform(0.02, 0.2);
  weather.conditioner_s = random.log_uniform(700.0, 3000.0);
  const int doors = random.below(4);
  for (int k = 0; k < doors; ++k) {
    weather.door_s.push_back(random.uniform(0.0, duration_s));
    weather.door_k.push_back(random.sign() * random.uniform(0.2, 1.2));
  }
  return weather;
}

}  // namespace

double RoomTrace::at(const Eigen::Ref<const VectorXd>& series, double time_s) const {
  const double place = std::clamp(time_s / step_s, 0.0, static_cast<double>(series.size() - 1));
  const auto low = static_cast<Eigen::Index>(place);
  const Eigen::Index high = std::min(low + 1, series.size() - 1);
  const double part = place - static_cast<double>(low);
  return series[low] * (1.0 - part) + series[high] * part;
}

VectorXd RoomTrace::lagged(const Eigen::Ref<const VectorXd>& series, double tau_s) const {
  VectorXd out(series.size());
  const double keep = std::exp(-step_s / tau_s);
  double state = series[0];
  for (Eigen::Index k = 0; k < series.size(); ++k) {
    state = series[k] + (state - series[k]) * keep;
    out[k] = state;
  }
  return out;
}

void spread_motion(RoomTrace& room, const std::vector<Move>& moves) {
  const Eigen::Index steps = room.motion.rows();
  for (const Move& move : moves) {
    const VectorXd length = (move.to - move.from).cwiseAbs();
    const double span = std::max(move.end_s - move.begin_s, 1e-6);
    for (Eigen::Index k = std::max(0L, static_cast<long>(move.begin_s / room.step_s));
         k < steps && static_cast<double>(k) * room.step_s < move.end_s; ++k) {
      const double low = std::max(move.begin_s, static_cast<double>(k) * room.step_s);
      const double high = std::min(move.end_s, static_cast<double>(k + 1) * room.step_s);
      if (high > low) {
        room.motion.row(k) += (length * ((high - low) / span / room.step_s)).transpose();
      }
    }
  }
}

RoomTrace make_room(double duration_s, int motors, const std::vector<Move>& moves,
                    const std::vector<ActivityChange>& activity,
                    const std::vector<Thermometer>& thermometers, Random& random) {
  RoomTrace room;
  room.step_s = std::max(1.0, duration_s / 8000.0);
  const auto steps = static_cast<Eigen::Index>(duration_s / room.step_s) + 3;
  const Weather weather = draw_weather(duration_s, random);
  room.air_degc.resize(steps);
  room.pressure_hpa.resize(steps);
  room.humidity_pct.resize(steps);
  room.motion.setZero(steps, motors);
  room.activity.setZero(steps);
  spread_motion(room, moves);
  // Pressure and humidity: Ornstein-Uhlenbeck weather of hours, on a slow trend.
  double pressure = 0.0;
  double humidity = 0.0;
  const double start_hpa = random.uniform(945.0, 1025.0);
  const double trend_hpa_per_h = random.sign() * random.uniform(0.1, 0.9);
  const double keep = std::exp(-room.step_s / 9000.0);
  std::size_t change = 0;
  double level = 0.0;
  for (Eigen::Index k = 0; k < steps; ++k) {
    const double time_s = static_cast<double>(k) * room.step_s;
    room.air_degc[k] = air_at(weather, time_s);
    const double kick = std::sqrt(1.0 - keep * keep);
    pressure = pressure * keep + 1.2 * kick * random.normal();
    humidity = humidity * keep + 2.0 * kick * random.normal();
    room.pressure_hpa[k] = start_hpa + trend_hpa_per_h * time_s / 3600.0 + pressure;
    room.humidity_pct[k] = 42.0 + humidity;
    while (change < activity.size() && activity[change].time_s <= time_s) {
      level = activity[change++].level;
    }
    room.activity[k] = level;
  }
  // Weather is smooth over minutes; the kicks are not.
  room.pressure_hpa = room.lagged(room.pressure_hpa, 600.0);
  room.humidity_pct = room.lagged(room.humidity_pct, 600.0);

  const VectorXd work = room.motion.rowwise().sum();
  const auto count = static_cast<Eigen::Index>(thermometers.size());
  room.body.resize(steps, count);
  room.sensed.resize(steps, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Thermometer& one = thermometers[static_cast<std::size_t>(k)];
    // The room was there before: the body has followed it for eight hours.
    double state = one.air_share * (air_at(weather, 0.0) - 20.0);
    for (double t = -8.0 * 3600.0; t < 0.0; t += 60.0) {
      const double drive = one.air_share * (air_at(weather, t) - 20.0);
      state = drive + (state - drive) * std::exp(-60.0 / one.tau_s);
    }
    const double hold = std::exp(-room.step_s / one.tau_s);
    for (Eigen::Index i = 0; i < steps; ++i) {
      const double drive = one.air_share * (room.air_degc[i] - 20.0) + one.motor_k * work[i] +
                           one.activity_k * room.activity[i];
      state = drive + (state - drive) * hold;
      room.body(i, k) = 20.0 + one.offset_k + state;
    }
    room.sensed.col(k) = one.filter_s > 0.0 ? room.lagged(room.body.col(k), one.filter_s)
                                            : VectorXd(room.body.col(k));
  }
  return room;
}

}  // namespace driftwise::foreign
