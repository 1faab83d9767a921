#pragma once
// Joint angles that bring a serial arm's tool to a pose, with all errors of its joints in: the
// inverse of SerialArm::posture(), by Newton's method (arm_solver.h) from the angles given and from
// drawn ones (seeded, so the same question has the same answer). The search ends when a pose can
// have no more solutions; after 16 starts for each that was found, 64 at least; after 48 that found
// none; after 256. A pose that the links are too short or too long for is refused before any start.
// Cost: some 10 microseconds near the angles given, milliseconds for a search.

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "server/kinematics/serial_arm.h"

namespace driftwise::kinematics {

struct WantedPose {  // in the measuring frame
  Eigen::Vector3d point_mm;
  std::optional<Eigen::Matrix3d> axes;  // of the last link; needed by six joints
};

struct JointSolution {
  std::vector<double> joints;  // in the channels' units
  double miss_nm = 0;          // of the forward model at these angles: the point ...
  double miss_arcsec = 0;      // ... and the axes; 0 without
  int solutions = 0;           // different ones found, turns of 360 degrees apart counted once; 0:
                               // Search::until_certain ended before all were looked for
  double least_motion = 0;     // of the tool per turn of the joints over the arm's reach: smallest
                               // singular value of the Jacobian
  std::uint32_t beyond = 0;    // a bit per joint beyond its limits: then every solution has one
};

// A pose where some turn of the joints of one radian moves the tool by less than this share of the
// arm's reach is near a singular one.
inline constexpr double kLeastMotion = 0.01;

// until_certain: the search ends with the first solution where no other can be nearer. Two
// solutions q, q' of n joints are at least 0.8 s / n rad apart, s the least motion at q: along the
// straight line between them the point's motion over the reach, and the axes' turn, add up to 0,
// while the Jacobian's product with the line changes by at most 1.5 n per rad, and a closed turn's
// sum of rotations differs from 0 by at most n / 2 times the square of the way. So a solution
// within s / (3 n) of `near` is the nearest: the case of a robot that follows a path by small
// steps.
enum class Search { all, until_certain };

// Of all solutions whose joints are within their limits the nearest to `near` (root of the sum of
// squares of the joints' differences, each joint at the turn of 360 degrees nearest to it that its
// limits allow); where none is, the nearest of all. values: one per parameter. temperatures:
// one per drift channel. Errors: invalid_argument BAD_KINEMATICS (joints that are not 3 or 6, six
// without axes); NO_POSE: out_of_range, nothing reaches it; failed_precondition NO_POSE(wrist),
// NO_POSE(elbow), NO_POSE(shoulder): near a singular pose.
Result<JointSolution> nearest_joints(const SerialArm& arm, const Eigen::VectorXd& values,
                                     const WantedPose& wanted, std::span<const double> near,
                                     std::span<const double> temperatures,
                                     Search search = Search::all);

// Whether that is a search by Search::until_certain, thus may take milliseconds: not for a thread
// that others wait for. arm, wanted: of 3 joints and a point, or of 6 and axes too.
bool needs_search(const SerialArm& arm, const Eigen::VectorXd& values, const WantedPose& wanted,
                  std::span<const double> near, std::span<const double> temperatures);

// Names the joints that are beyond their limits: out_of_range OUTSIDE_LIMITS(q3).
Error beyond_limits(const SerialArm& arm, const JointSolution& solution);

}  // namespace driftwise::kinematics
