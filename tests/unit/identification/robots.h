#pragma once
// Simulated robots for the tests of identification. Their mathematics is their own: products of
// 4 x 4 matrices for the arm, a search along the axis for the delta. Seeded.

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <string>

#include "server/core/data/dataset.h"
#include "server/core/description/kinematics_description.h"

namespace driftwise::identification::robots {

constexpr double kDeg = M_PI / 180;
using Transform = Eigen::Isometry3d;

inline Transform turn(double deg, const Eigen::Vector3d& axis) {
  return Transform(Eigen::AngleAxisd(deg * kDeg, axis));
}
inline Transform shift(double x, double y, double z) {
  return Transform(Eigen::Translation3d(x, y, z));
}

// The joint angles in rad.
inline Eigen::Vector3d arm_point(const KinematicsDescription& arm, const std::vector<double>& q) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(),
                        z = Eigen::Vector3d::UnitZ();
  const auto& f = arm.frame;
  Transform chain =
      shift(f.x_mm, f.y_mm, f.z_mm) * turn(f.rz_deg, z) * turn(f.ry_deg, y) * turn(f.rx_deg, x);
  for (std::size_t i = 0; i < arm.links.size(); ++i) {
    const auto& link = arm.links[i];
    chain = chain * turn(link.theta_deg + q[i] / kDeg, z) * shift(link.a_mm, 0, link.d_mm) *
            turn(link.alpha_deg, x) * turn(link.beta_deg, y);
  }
  return chain * Eigen::Vector3d(arm.tool_x_mm, arm.tool_y_mm, arm.tool_z_mm);
}

// Random joint angles over the workspace, measured with noise.
inline Dataset arm_campaign(const KinematicsDescription& arm, std::size_t rows, double noise_mm,
                            unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> angle(-2.5, 2.5);
  std::normal_distribution<double> normal;
  Dataset data;
  data.rows = rows;
  for (const auto& link : arm.links) data.columns.push_back({link.motor, {}});
  for (const char* axis : {"x", "y", "z"}) data.columns.push_back({{axis, "mm"}, {}});
  for (std::size_t row = 0; row < rows; ++row) {
    std::vector<double> q(arm.links.size());
    for (auto& one : q) one = angle(random);
    const Eigen::Vector3d point = arm_point(arm, q);
    for (std::size_t i = 0; i < q.size(); ++i) data.columns[i].values.push_back(q[i]);
    for (std::size_t i = 0; i < 3; ++i)
      data.columns[q.size() + i].values.push_back(point[static_cast<Eigen::Index>(i)] +
                                                  noise_mm * normal(random));
  }
  return data;
}

// Some poses again and again; the joints come to rest within 1e-5 rad and say where.
inline Dataset visits(const KinematicsDescription& arm, std::size_t poses, std::size_t times,
                      double noise_mm, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> angle(-1.5, 1.5);
  std::normal_distribution<double> normal;
  Dataset data;
  data.rows = poses * times;
  for (const auto& link : arm.links) data.columns.push_back({link.motor, {}});
  for (const char* axis : {"x", "y", "z"}) data.columns.push_back({{axis, "mm"}, {}});
  std::vector<std::vector<double>> at(poses, std::vector<double>(arm.links.size()));
  for (auto& pose : at)
    for (auto& one : pose) one = angle(random);
  for (std::size_t row = 0; row < data.rows; ++row) {
    auto q = at[row % poses];
    for (auto& one : q) one += 1e-5 * normal(random);
    const Eigen::Vector3d point = arm_point(arm, q);
    for (std::size_t i = 0; i < q.size(); ++i) data.columns[i].values.push_back(q[i]);
    for (std::size_t i = 0; i < 3; ++i)
      data.columns[q.size() + i].values.push_back(point[static_cast<Eigen::Index>(i)] +
                                                  noise_mm * normal(random));
  }
  return data;
}

// Where the carriage must stand for the pose: bisection on the arm's length, from the definition.
inline double delta_scale(const DeltaBranch& branch, bool above, const Eigen::Vector3d& pose) {
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  const Transform azimuth = turn(branch.azimuth_deg, z);
  const Eigen::Vector3d outwards = azimuth * Eigen::Vector3d::UnitX();
  const Eigen::Vector3d left = azimuth * Eigen::Vector3d::UnitY();
  Eigen::Vector3d axis = turn(branch.tilt_radial_deg, left) * z;  // outwards
  axis = turn(branch.tilt_tangential_deg, -(turn(branch.tilt_radial_deg, left) * outwards)) * axis;
  const double side = above ? 1 : -1;
  const double drop =
      std::sqrt(branch.length_mm * branch.length_mm - branch.radius_mm * branch.radius_mm);
  const Eigen::Vector3d foot = branch.radius_mm * outwards + side * drop * z;
  const auto excess = [&](double q) { return (pose - foot - q * axis).norm() - branch.length_mm; };
  double low = -0.5 * drop, high = 0.5 * drop;
  if (excess(low) > excess(high)) std::swap(low, high);
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (excess(middle) < 0 ? low : high) = middle;
  }
  return (0.5 * (low + high) + branch.offset_mm) * (1 + 1e-6 * branch.scale_ppm);
}

struct DeltaNoise {
  double mm = 0;
  double per_degc_mm = 0;  // times 1, 2, 3 for the three axes
  double per_n_mm = 0;
};

// A grid of n^3 poses over 0 .. 2.5 mm, room warming by 3 K, force in three steps.
inline Dataset delta_campaign(const KinematicsDescription& delta, int n, const DeltaNoise& noise,
                              unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Dataset data;
  for (const char* name : {"x", "y", "z", "q1", "q2", "q3"})
    data.columns.push_back({{name, "mm"}, {}});
  data.columns.push_back({{"t05", "degC"}, {}});
  data.columns.push_back({{"force", "N"}, {}});
  const int total = n * n * n;
  for (int i = 0; i < total; ++i) {
    const double step = 2.5 / (n - 1);
    const Eigen::Vector3d pose(step * (i % n), step * (i / n % n), step * (i / n / n));
    // Up, down and up again, so that heat is not position.
    const double degc = 23 + 1.5 * std::sin(9.0 * i / total), force = 1.2 * ((i * 7) % 3);
    data.time_s.push_back(15.0 * i);
    for (int k = 0; k < 3; ++k) data.columns[static_cast<std::size_t>(k)].values.push_back(pose[k]);
    for (std::size_t k = 0; k < 3; ++k)
      data.columns[3 + k].values.push_back(
          delta_scale(delta.branches[k], delta.carriages_above, pose) +
          noise.per_degc_mm * static_cast<double>(k + 1) * (degc - 23) + noise.per_n_mm * force +
          noise.mm * normal(random));
    data.columns[6].values.push_back(degc);
    data.columns[7].values.push_back(force);
  }
  data.rows = static_cast<std::size_t>(total);
  return data;
}

inline KinematicsDescription nominal_delta() {
  KinematicsDescription delta;
  delta.kind = "delta-vertical";
  for (int i = 0; i < 3; ++i)
    delta.branches.push_back({.motor = {"q" + std::to_string(i + 1), "mm"},
                              .azimuth_deg = 120.0 * i,
                              .radius_mm = 45,
                              .length_mm = 70});
  return delta;
}

inline KinematicsDescription nominal_arm() {
  KinematicsDescription arm;
  arm.kind = "serial-arm";
  const double d[] = {127.3, 0, 0, 163.9, 115.7, 92.2}, a[] = {0, -612, -572.3, 0, 0, 0},
               alpha[] = {90, 0, 0, 90, -90, 0};
  for (int i = 0; i < 6; ++i)
    arm.links.push_back({.motor = {"q" + std::to_string(i + 1), "rad"},
                         .d_mm = d[i],
                         .a_mm = a[i],
                         .alpha_deg = alpha[i]});
  arm.tool_x_mm = 20;
  arm.tool_y_mm = -35;
  arm.tool_z_mm = 109;
  return arm;
}

}  // namespace driftwise::identification::robots
