#include "tests/hidden_effects/joint/two_robot_plant.h"

#include <algorithm>
#include <cmath>

namespace joint_plant {
namespace {

constexpr double kArcsec = 3.14159265358979323846 / (180.0 * 3600.0);  // rad
constexpr double kScaleMm = 0.25e-3;                                   // of the MinAngle's motors
constexpr double kReference = 20.0;  // degC at which sizes are meant

double counted(double value, double step) { return step * std::round(value / step); }

// 3 x 3 by Cramer's rule.
std::array<double, 3> solved(const std::array<std::array<double, 3>, 3>& m,
                             const std::array<double, 3>& right) {
  const auto det = [](const std::array<std::array<double, 3>, 3>& a) {
    return a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) -
           a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
           a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
  };
  const double whole = det(m);
  std::array<double, 3> out{};
  for (std::size_t c = 0; c < 3; ++c) {
    auto replaced = m;
    for (std::size_t r = 0; r < 3; ++r) replaced[r][c] = right[r];
    out[c] = det(replaced) / whole;
  }
  return out;
}

}  // namespace

Room::Room(std::uint64_t seed, double start_degc, double end_degc, double hours)
    : start_(start_degc),
      end_(end_degc),
      seconds_(hours * 3600),
      support_(start_degc),
      screws_(start_degc),
      structure_(start_degc),
      random_(seed) {
  wave_phase_ = std::uniform_real_distribution<>(0, 6.28)(random_);
}

// Warms as a room does whose cooling was switched off, with the air conditioning's slow wave.
double Room::air() const {
  const double warmed = (1 - std::exp(-2 * now_s_ / seconds_)) / (1 - std::exp(-2.0));
  return start_ + (end_ - start_) * warmed +
         0.05 * (std::sin(now_s_ / 900 + wave_phase_) - std::sin(wave_phase_));
}

void Room::advance(double seconds) {
  for (double left = seconds; left > 0; left -= 10) {
    const double dt = std::min(10.0, left);
    now_s_ += dt;
    support_ += dt * (air() - support_) / 1500;
    screws_ += dt * (air() - screws_) / 1000;
    structure_ += dt * (air() - structure_) / 2400;
  }
}

double Room::noisy(double value) { return value + std::normal_distribution<>(0, 0.002)(random_); }
double Room::t05() { return noisy(support_); }
double Room::t08() { return noisy(screws_); }
double Room::t09() { return noisy(structure_); }

MinAngle::MinAngle(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto within = [&random](double low, double high) {
    return std::uniform_real_distribution<>(low, high)(random);
  };
  for (std::size_t i = 0; i < 3; ++i) {
    radius_[i] = 60 + within(-0.05, 0.05);
    azimuth_[i] = 2.0943951023931953 * static_cast<double>(i) + within(-0.002, 0.002);
  }
  screw_um_per_k_ = within(1.0, 2.0);
  dx_per_k_ = within(0.6, 0.8);
  dy_per_k_ = within(1.5, 1.9);
  tilt_lever_mm_ = within(0.1, 0.4);
  // 7 um and 27 um at 4 mm.
  dx_ = {within(1.2, 1.6), within(-0.06, 0.06), within(0.01, 0.03)};
  dy_ = {within(-6.0, -5.0), within(-0.15, 0.15), within(-0.08, -0.04)};
}

std::array<double, 3> MinAngle::motors_at(double rx, double ry, double z, const Room& room) const {
  std::array<double, 3> q{};
  const double screw_mm = screw_um_per_k_ * 1e-3 * (room.screws_degc() - kReference);
  for (std::size_t i = 0; i < 3; ++i)
    q[i] = z - screw_mm +
           radius_[i] * (std::sin(azimuth_[i]) * std::tan(rx * kArcsec) -
                         std::cos(azimuth_[i]) * std::tan(ry * kArcsec) / std::cos(rx * kArcsec));
  return q;
}

std::array<double, 3> MinAngle::read_back(const std::array<double, 3>& q) {
  return {counted(q[0], kScaleMm), counted(q[1], kScaleMm), counted(q[2], kScaleMm)};
}

Pose MinAngle::pose(const std::array<double, 3>& q, const Room& room) const {
  const auto reached = read_back(q);
  Pose pose;
  // Newton: three equations in rx, ry, z.
  for (int k = 0; k < 6; ++k) {
    const auto at = motors_at(pose.rx, pose.ry, pose.z, room);
    std::array<std::array<double, 3>, 3> slope{};
    const auto by_rx = motors_at(pose.rx + 1, pose.ry, pose.z, room);
    const auto by_ry = motors_at(pose.rx, pose.ry + 1, pose.z, room);
    std::array<double, 3> rest{};
    for (std::size_t i = 0; i < 3; ++i) {
      slope[i] = {by_rx[i] - at[i], by_ry[i] - at[i], 1.0};
      rest[i] = reached[i] - at[i];
    }
    const auto step = solved(slope, rest);
    pose.rx += step[0];
    pose.ry += step[1];
    pose.z += step[2];
  }
  const double z = pose.z, warm = room.structure_degc() - kReference;
  pose.x = 1e-3 * (dx_[0] * z + dx_[1] * z * z + dx_[2] * z * z * z + dx_per_k_ * warm) +
           tilt_lever_mm_ * pose.ry * kArcsec;
  pose.y = 1e-3 * (dy_[0] * z + dy_[1] * z * z + dy_[2] * z * z * z + dy_per_k_ * warm) -
           tilt_lever_mm_ * pose.rx * kArcsec;
  return pose;
}

MicroNano::MicroNano(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto within = [&random](double low, double high) {
    return std::uniform_real_distribution<>(low, high)(random);
  };
  for (std::size_t i = 0; i < 3; ++i) {
    arm_mm_[i] = 70 + within(-1, 1);
    squareness_[i] = within(-2e-4, 2e-4);
    um_per_k_[i] = within(-1.0, 1.0);
  }
  // Up to about 50 arcsec at the corner of 2.5 mm: mostly of first degree.
  for (auto& surface : tilt_) {
    for (std::size_t k = 0; k < 3; ++k) surface[k] = within(-6, 6);
    for (std::size_t k = 3; k < 6; ++k) surface[k] = within(-1, 1);
    for (std::size_t k = 6; k < 9; ++k) surface[k] = within(-0.15, 0.15);
  }
}

Pose MicroNano::pose(const std::array<double, 3>& q, const Room& room) const {
  const double warm = room.support_degc() - kReference;
  const auto fall = [](double side, double arm) {
    return arm - std::sqrt(arm * arm - side * side);
  };
  Pose pose;
  pose.x = q[0] - fall(q[1], arm_mm_[0]) - fall(q[2], arm_mm_[0]) + squareness_[0] * q[1] +
           1e-3 * um_per_k_[0] * warm;
  pose.y = q[1] - fall(q[0], arm_mm_[1]) - fall(q[2], arm_mm_[1]) + squareness_[1] * q[2] +
           1e-3 * um_per_k_[1] * warm;
  pose.z = q[2] - fall(q[0], arm_mm_[2]) - fall(q[1], arm_mm_[2]) + squareness_[2] * q[0] +
           1e-3 * um_per_k_[2] * warm;
  const double x = pose.x, y = pose.y, z = pose.z;
  const auto tilt = [&](const std::array<double, 9>& s) {
    return s[0] * x + s[1] * y + s[2] * z + s[3] * x * x + s[4] * x * y + s[5] * y * z +
           s[6] * x * x * x + s[7] * y * y * z + s[8] * z * z * z;
  };
  pose.rx = tilt(tilt_[0]);
  pose.ry = tilt(tilt_[1]);
  pose.rz = tilt(tilt_[2]);
  return pose;
}

std::array<double, 3> MicroNano::motors_at(double x, double y, double z, const Room& room) const {
  std::array<double, 3> q = {x, y, z};
  for (int k = 0; k < 30; ++k) {  // the curvature is small: a fixed point
    const Pose at = pose(q, room);
    q[0] += x - at.x;
    q[1] += y - at.y;
    q[2] += z - at.z;
  }
  return q;
}

double Instruments::laser_mm(double true_mm) {
  return true_mm + std::normal_distribution<>(0, 10e-6)(random_);
}
double Instruments::collimator_arcsec(double true_arcsec) {
  return true_arcsec + std::normal_distribution<>(0, 0.05)(random_);
}
double Instruments::inclinometer_arcsec(double true_arcsec) {
  return counted(true_arcsec + std::normal_distribution<>(0, 10)(random_), 36);
}
double Instruments::probe_mm(double true_mm) {
  constexpr double kFriction = 0.5e-3;  // the tip follows once the spring has it by this much
  stuck_mm_ = std::clamp(stuck_mm_, true_mm - kFriction, true_mm + kFriction);
  return counted(stuck_mm_, 50e-6);
}

}  // namespace joint_plant
