#pragma once
// The closed loop of a delta robot: a platform on six bars, two to each carriage. With equal bars
// in each pair and parallel joint lines the platform cannot turn; with real ones it does, and the
// loop says by how much: all six distances are kept exactly, nothing is linearised.

#include <array>

#include "drivers/simulated/plant/numbers/vector3.h"

namespace driftwise::simulated {

inline constexpr std::size_t kBars = 6;  // bars 2 i and 2 i + 1 belong to carriage i

struct Bar {
  Vec3 carriage_mm;  // joint on the carriage, in the robot's base
  Vec3 platform_mm;  // joint on the platform, in the platform's frame
  double length_mm = 0;
};

struct PlatformPose {
  Vec3 centre_mm;
  Rotation turn;
};

// Where the platform is: Newton's iteration on the six distances, from `start`; quadratic, three or
// four rounds from anywhere in the workspace, to 1e-11 mm. Throws std::domain_error when the bars
// cannot be closed.
PlatformPose closed_pose(const std::array<Bar, kBars>& bars, const PlatformPose& start);

// A force through the platform's centre and a moment about it, N and N mm.
struct Wrench {
  Vec3 force_n, moment_nmm;
};

// What each bar carries so that the platform rests under the wrench: + is tension.
std::array<double, kBars> bar_forces_n(const std::array<Bar, kBars>& bars, const PlatformPose& pose,
                                       const Wrench& wrench);

}  // namespace driftwise::simulated
