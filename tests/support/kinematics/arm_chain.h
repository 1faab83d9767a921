#pragma once
// A serial arm's forward model by homogeneous matrices multiplied one after the other, with the
// errors of its joints: what the daemon's kinematics are held against. Knows the description of an
// arm, and nothing of server/kinematics.

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "server/core/description/kinematics_description.h"

namespace driftwise::tests {

inline constexpr double kDeg = std::numbers::pi / 180, kArcsec = kDeg / 3600;

inline Eigen::Matrix4d turn(int axis, double angle) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  m(u, u) = m(v, v) = std::cos(angle);
  m(v, u) = std::sin(angle);
  m(u, v) = -std::sin(angle);
  return m;
}
inline Eigen::Matrix4d shift(double x, double y, double z) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.col(3) << x, y, z, 1;
  return m;
}

// The robot's base to its tool; heights: length times height of each bar, mm^2, by the joint that
// carries it.
struct Chain {
  Eigen::Matrix4d tool;
  std::vector<double> lengths, moments;
};
inline Chain chain_of(const KinematicsDescription& arm, const std::vector<double>& angles) {
  Chain chain{Eigen::Matrix4d::Identity(), {}, {}};
  for (std::size_t j = 0; j < arm.links.size(); ++j) {
    const auto& link = arm.links[j];
    double length = 0, moment = 0;
    const auto bar = [&](const Eigen::Matrix4d& by) {
      const double from = chain.tool(2, 3);
      chain.tool = chain.tool * by;
      const double long_mm = by.block<3, 1>(0, 3).norm();
      length += long_mm;
      moment += long_mm * (from + chain.tool(2, 3)) / 2;
    };
    chain.tool = chain.tool * turn(2, link.theta_deg * kDeg + angles[j]);
    bar(shift(0, 0, link.d_mm));
    bar(shift(link.a_mm, 0, 0));
    chain.tool = chain.tool * turn(0, link.alpha_deg * kDeg) * turn(1, link.beta_deg * kDeg);
    if (j + 1 == arm.links.size()) bar(shift(arm.tool_x_mm, arm.tool_y_mm, arm.tool_z_mm));
    chain.lengths.push_back(length);
    chain.moments.push_back(moment);
  }
  return chain;
}

// Of the bars that joint j carries: minus the slope of their centre's height by its angle, in m.
inline double lever_m(const KinematicsDescription& arm, std::vector<double> angles, std::size_t j) {
  constexpr double kStep = 1e-5;
  double weight = 0, slope = 0;
  for (const double side : {1.0, -1.0}) {
    auto moved = angles;
    moved[j] += side * kStep;
    const auto chain = chain_of(arm, moved);
    weight = 0;
    for (std::size_t k = j; k < arm.links.size(); ++k) {
      weight += chain.lengths[k];
      slope += side * chain.moments[k];
    }
  }
  return -1e-3 * slope / (2 * kStep) / weight;
}

// The tool in the measuring frame, errors of the joints in.
inline Eigen::Matrix4d forward(const KinematicsDescription& arm, const std::vector<double>& q,
                               double degC) {
  auto angles = q;
  for (std::size_t j = 0; j < q.size(); ++j) {
    const auto& e = arm.links[j].errors;
    angles[j] +=
        kArcsec *
        (e.gear_cos1_arcsec * std::cos(q[j]) + e.gear_sin1_arcsec * std::sin(q[j]) +
         e.gear_cos2_arcsec * std::cos(2 * q[j]) + e.gear_sin2_arcsec * std::sin(2 * q[j]));
    if (e.sag_urad_per_m != 0) angles[j] += 1e-6 * e.sag_urad_per_m * lever_m(arm, q, j);
    if (!e.drift_channel.symbol.empty())
      angles[j] += kArcsec * e.drift_arcsec_per_k * (degC - e.drift_from_degC);
  }
  const auto& f = arm.frame;
  return shift(f.x_mm, f.y_mm, f.z_mm) * turn(2, f.rz_deg * kDeg) * turn(1, f.ry_deg * kDeg) *
         turn(0, f.rx_deg * kDeg) * chain_of(arm, angles).tool;
}

// Rz Ry Rx of a rotation, arcsec.
inline std::array<double, 3> rotations_arcsec(const Eigen::Matrix4d& m) {
  return {std::atan2(m(2, 1), m(2, 2)) / kArcsec,
          std::atan2(-m(2, 0), std::hypot(m(0, 0), m(1, 0))) / kArcsec,
          std::atan2(m(1, 0), m(0, 0)) / kArcsec};
}

// Its points at drawn joint angles, measured to 20 um, every fourth for validation: a dataset CSV.
inline std::string measured_csv(const KinematicsDescription& arm, int rows) {
  std::mt19937 random(20261123);
  std::uniform_real_distribution<double> turn_rad(-2.5, 2.5), lift(-2.2, -0.6), bend(0.6, 2.1);
  std::normal_distribution<double> noise_mm(0, 0.02);
  std::ostringstream csv;
  csv.precision(17);
  csv << "time_s,set,q1_rad,q2_rad,q3_rad,q4_rad,q5_rad,q6_rad,x_mm,y_mm,z_mm\n";
  for (int row = 0; row < rows; ++row) {
    const double first = turn_rad(random), second = lift(random), third = bend(random);
    const double fourth = turn_rad(random), fifth = bend(random), sixth = turn_rad(random);
    const std::vector<double> q = {first, second, third, fourth, fifth, sixth};
    const auto tool = forward(arm, q, 20);
    csv << 10 * row << (row % 4 == 3 ? ",validation" : ",calibration");
    for (const double angle : q) csv << ',' << angle;
    for (int k : {0, 1, 2}) csv << ',' << tool(k, 3) + noise_mm(random);
    csv << '\n';
  }
  return csv.str();
}

}  // namespace driftwise::tests
