#pragma once
// Three set-ups of one robot, and one that measures all six coordinates: what each would record of
// the same grid, from a pose that is known.

#include <array>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "server/core/units.h"
#include "server/correction/dataset_join.h"

namespace driftwise::correction::set_ups {

inline constexpr double kLever_mm = 12;

struct Pose {
  double x, y, z, rx, ry, rz;  // mm, arcsec
};

// A robot of three motors with parasitic rotations of some arcseconds.
inline Pose pose_of(double q1, double q2, double q3) {
  return {
      q1 + 0.01 * q2 - 0.002 * q1 * q3, q2 - 0.01 * q1 + 0.001 * q1 * q1, q3 + 0.003 * q1 * q2,
      4.0 * q2 + 1.5 * q1 * q3,         -6.0 * q1 + 0.8 * q2 * q2,        3.0 * q3 - 2.0 * q1 * q2};
}

struct SetUp {
  const char* name;
  std::vector<std::string> measures;
  unsigned seed;
  double drift_nm;          // of every length over the session
  bool two_places = false;  // each motor rests 30 nm to either side, never between
};
inline const SetUp kFirst{"first", {"x", "ry", "rz"}, 1, 40};
inline const SetUp kSecond{"second", {"y", "rx", "ry"}, 2, -30};
inline const SetUp kThird{"third", {"z"}, 3, 20};
inline const SetUp kFirstAgain{"again", {"x", "ry", "rz"}, 5, -20};
inline const SetUp kAll{"all", {"x", "y", "z", "rx", "ry", "rz"}, 4, 40};

struct GridPoint {
  double q1, q2, q3;
  bool zero;
};
// 5 x 5 x 5, a return to zero before each line and at the end.
inline std::vector<GridPoint> grid() {
  std::vector<GridPoint> points;
  for (int a = -2; a <= 2; ++a)
    for (int b = -2; b <= 2; ++b) {
      points.push_back({0, 0, 0, true});
      for (int c = -2; c <= 2; ++c) points.push_back({0.5 * c, 0.5 * b, 0.5 * a, false});
    }
  points.push_back({0, 0, 0, true});
  return points;
}

// What a set-up reads: paths along beams that meet their mirrors kLever_mm off the centre, with
// 5 nm and 0.03 arcsec of noise and 25 nm of holding error. Lengths as the cell's own correction
// stage leaves them: each set-up knows its own angles only.
inline JoinPart measured(const SetUp& set_up) {
  std::mt19937 random(set_up.seed);
  std::normal_distribution<double> normal;
  JoinPart part;
  part.name = set_up.name;
  part.tool = "cube";
  Stage stage;
  stage.cosine = true;
  for (auto& beam : stage.beams) beam.at_zero_mm = {kLever_mm, kLever_mm, kLever_mm};
  part.stage = stage;
  auto& data = part.data;
  const auto column = [&data](const char* symbol, const char* unit) {
    data.columns.push_back({{symbol, unit}, {}});
  };
  for (const char* q : {"q1", "q2", "q3"}) column(q, "mm");
  for (const auto& symbol : set_up.measures) {
    if (symbol.size() == 1) column((symbol + "_path").c_str(), "mm");
    column(symbol.c_str(), symbol.size() == 1 ? "mm" : "arcsec");
  }
  column("t05", "degC");
  const auto points = grid();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& point = points[i];
    const double share = static_cast<double>(i) / static_cast<double>(points.size());
    std::array<double, 3> q{point.q1, point.q2, point.q3};
    for (double& one : q) {
      const double holding = normal(random);
      one += set_up.two_places ? std::copysign(30e-6, holding) : 25e-6 * holding;
    }
    Pose pose = pose_of(q[0], q[1], q[2]);
    const double drift_mm = set_up.drift_nm * 1e-6 * share;
    pose.x += drift_mm, pose.y += drift_mm, pose.z += drift_mm;
    const double rx = rad_from_arcsec(pose.rx), ry = rad_from_arcsec(pose.ry),
                 rz = rad_from_arcsec(pose.rz);
    // Rigid body: the mirror's point at the lever a moves by rotation x a.
    const std::array<double, 3> path = {
        (pose.x + (ry - rz) * kLever_mm) / (std::cos(ry) * std::cos(rz)),
        (pose.y + (rz - rx) * kLever_mm) / (std::cos(rx) * std::cos(rz)),
        (pose.z + (rx - ry) * kLever_mm) / (std::cos(rx) * std::cos(ry))};
    const std::array<double, 3> angle = {pose.rx, pose.ry, pose.rz};
    Vector3 read_mm{};
    Tilt read;
    for (const auto& symbol : set_up.measures) {
      const auto axis = static_cast<std::size_t>(symbol.back() - 'x');
      if (symbol.size() == 1)
        read_mm[axis] = path[axis] + 5e-6 * normal(random);
      else
        (axis == 0   ? read.rx_arcsec
         : axis == 1 ? read.ry_arcsec
                     : read.rz_arcsec) = angle[axis] + 0.03 * normal(random);
    }
    const auto corrected = pose_from_paths(read_mm, read, stage);
    std::size_t at = 0;
    const auto put = [&](double value) { data.columns[at++].values.push_back(value); };
    for (const double one : q) put(one);
    for (const auto& symbol : set_up.measures) {
      const auto axis = static_cast<std::size_t>(symbol.back() - 'x');
      if (symbol.size() == 1) {
        put(read_mm[axis]);
        put(corrected[axis]);
      } else {
        put(axis == 0 ? read.rx_arcsec : axis == 1 ? read.ry_arcsec : read.rz_arcsec);
      }
    }
    put(20 + 0.1 * share);
    data.time_s.push_back(15.0 * static_cast<double>(i));
    data.zero.push_back(point.zero ? 1 : 0);
  }
  data.rows = points.size();
  return part;
}

inline JoinParts three() { return {measured(kFirst), measured(kSecond), measured(kThird)}; }

inline DatasetColumn& column(JoinPart& part, const std::string& symbol) {
  for (auto& one : part.data.columns)
    if (one.channel.symbol == symbol) return one;
  throw std::runtime_error("no column " + symbol);
}

}  // namespace driftwise::correction::set_ups
