#pragma once
// Pose accuracy and pose repeatability of a robot, after ISO 9283: five poses, thirty cycles, each
// pose always approached alike.
//
// With the attained positions p_j, j = 1..n, of one pose, their barycentre p and the command p_c:
//   AP = |p - p_c|, and p - p_c by axis; l_j = |p_j - p|; RP = mean l + 3 S_l (n - 1);
// for each rotation a: AP_a = mean a - a_c; RP_a = 3 S_a.
// Rotations are the recorded angles about x, y, z; differences are taken within half a turn.
// Sources: docs/standards.md.

#include <array>
#include <string>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/standards/conditions.h"

namespace driftwise::standards {

struct Iso9283Options {
  // Symbols of what was commanded and measured, as many of each; empty: x, y, z as far as they are
  // there, commanded by x_target, goal_x or q1_cmd and so on.
  std::vector<std::string> command = {}, measured = {};
  // The same of rotations; empty: rx, ry, rz as far as they are there, commanded by rx_target or
  // goal_rx, else 0.
  std::vector<std::string> rotation_command = {}, rotation_measured = {};
  int poses = 5, cycles = 30;
  double same_pose_mm = 1e-6, same_pose_arcsec = 1e-3;  // commands that are one pose
  bool accuracy = true;  // false: command and measurement stand in different frames, only RP counts
};

struct Iso9283Pose {
  std::vector<double> command_mm;  // by axis
  std::vector<double> rotation_command_arcsec;
  std::size_t cycles = 0;
  double ap_nm = kMissing;  // position; kMissing without accuracy
  std::vector<double> ap_axis_nm;
  double rp_nm = 0, mean_l_nm = 0, s_l_nm = 0;
  std::vector<double> ap_rotation_arcsec, rp_rotation_arcsec;  // by rotation, AP with its sign
};

struct Iso9283 {
  std::vector<std::string> axes, rotations;  // symbols measured
  std::vector<Iso9283Pose> poses;            // in the order of their first visits
  double worst_ap_nm = kMissing, worst_rp_nm = 0;
  std::vector<double> worst_ap_rotation_arcsec, worst_rp_rotation_arcsec;  // by size
  Conditions conditions;
  std::vector<std::string> warnings;
};

// Of more cycles the last ones in time count. Poses visited fewer times than a fifth of the cycles
// (where the robot turned or started) and returns to zero belong to no figure, when enough others
// are there. Errors: invalid_argument NO_COLUMN, UNIT_KIND, BAD_COLUMNS; failed_precondition
// LACKS_CYCLES (which pose has how many), TOO_FEW_POSES.
Result<Iso9283> iso9283(const Dataset& dataset, const Iso9283Options& options);

}  // namespace driftwise::standards
