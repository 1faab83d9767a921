#include "drivers/simulated/plant/micro_nano/six_bars.h"

#include <cmath>
#include <stdexcept>
#include <utility>

namespace driftwise::simulated {
namespace {

using Six = std::array<double, kBars>;
using SixBySix = std::array<Six, kBars>;

// Gauss with row exchange. False: singular.
bool solve(SixBySix& a, Six& b) {
  for (std::size_t k = 0; k < kBars; ++k) {
    std::size_t best = k;
    for (std::size_t i = k + 1; i < kBars; ++i) {
      if (std::abs(a[i][k]) > std::abs(a[best][k])) best = i;
    }
    if (std::abs(a[best][k]) < 1e-9) return false;
    std::swap(a[k], a[best]);
    std::swap(b[k], b[best]);
    for (std::size_t i = k + 1; i < kBars; ++i) {
      const double factor = a[i][k] / a[k][k];
      for (std::size_t j = k; j < kBars; ++j) a[i][j] -= factor * a[k][j];
      b[i] -= factor * b[k];
    }
  }
  for (std::size_t k = kBars; k-- > 0;) {
    for (std::size_t j = k + 1; j < kBars; ++j) b[k] -= a[k][j] * b[j];
    b[k] /= a[k][k];
  }
  return true;
}

// How a bar's length grows with the platform's motion: its direction, and lever x direction.
Six row_of(const Bar& bar, const PlatformPose& pose, double& length_mm) {
  const Vec3 lever = pose.turn * bar.platform_mm;
  const Vec3 along = pose.centre_mm + lever - bar.carriage_mm;
  length_mm = norm(along);
  const Vec3 u = (1 / length_mm) * along;
  const Vec3 m = cross(lever, u);
  return {u.x, u.y, u.z, m.x, m.y, m.z};
}

}  // namespace

PlatformPose closed_pose(const std::array<Bar, kBars>& bars, const PlatformPose& start) {
  constexpr int kMostRounds = 20;
  PlatformPose pose = start;
  for (int round = 0; round < kMostRounds; ++round) {
    SixBySix rows{};
    Six step{};
    for (std::size_t k = 0; k < kBars; ++k) {
      double length_mm = 0;
      rows[k] = row_of(bars[k], pose, length_mm);
      step[k] = bars[k].length_mm - length_mm;
    }
    if (!solve(rows, step)) break;
    const Vec3 turn{step[3], step[4], step[5]};
    pose.centre_mm = pose.centre_mm + Vec3{step[0], step[1], step[2]};
    pose.turn = rotation_by(turn) * pose.turn;
    double size = 0;
    for (const double value : step) size = std::max(size, std::abs(value));
    if (size > 100) break;
    // Quadratic: after a step this small the next one would be below the last digit.
    if (size < 1e-6) return pose;
  }
  throw std::domain_error("six bars: they cannot be closed at these positions");
}

std::array<double, kBars> bar_forces_n(const std::array<Bar, kBars>& bars, const PlatformPose& pose,
                                       const Wrench& wrench) {
  SixBySix columns{};
  for (std::size_t k = 0; k < kBars; ++k) {
    double unused = 0;
    const Six row = row_of(bars[k], pose, unused);
    for (std::size_t i = 0; i < kBars; ++i) columns[i][k] = row[i];
  }
  // A bar in tension pulls the platform back towards its carriage: sum of f (-u) + wrench = 0.
  Six forces{wrench.force_n.x,    wrench.force_n.y,    wrench.force_n.z,
             wrench.moment_nmm.x, wrench.moment_nmm.y, wrench.moment_nmm.z};
  if (!solve(columns, forces)) throw std::domain_error("six bars: no equilibrium here");
  return forces;
}

}  // namespace driftwise::simulated
