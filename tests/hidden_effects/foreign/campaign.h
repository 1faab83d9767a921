#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "tests/hidden_effects/foreign/noise.h"
#include "tests/hidden_effects/foreign/plan.h"
#include "tests/hidden_effects/foreign/robot.h"
#include "tests/hidden_effects/foreign/room.h"

namespace driftwise::foreign {

// What a hidden cause needs to be present in a data table.
struct Needs {
  int thermometers = 0;
  // Thermometers that the baseline does not offer.
  int spare = 0;
  bool force = false;
  // Force is in the table and acts, and the baseline does not offer it.
  bool force_left_out = false;
  bool activity = false;
  bool tilts = false;
  bool air = false;
  bool times = false;
  // No thermometer may see the heat of the motors, or of the activity.
  bool unsensed_heat = false;
  // At most this degree of baseline geometry, so that one more is determined by the places.
  int degree = 3;
};

// Which part of the world is drawn at random; the rest is the reference laboratory.
struct Variation {
  bool robot = true;
  bool plan = true;
  bool noise = true;
  bool sensors = true;
};

struct CampaignChoice {
  // Empty: drawn (or the reference).
  std::string robot;
  std::string plan;
  std::string noise;
  // Plans and robots kept for the full count.
  bool reserved = false;
  Variation vary;
};

// A measuring campaign without hidden effect and without noise: robot, plan, room and sensors.
//
// Rows are measured stops in order of time. Motor values are normalised (Robot). Temperatures in
// degC.
struct Campaign {
  Robot robot;
  std::string plan;
  Noise noise;
  RoomTrace room;
  std::vector<Thermometer> thermometers;
  std::vector<Move> moves;
  std::vector<Visit> visits;

  Eigen::VectorXd time_s;
  Eigen::MatrixXd s;
  Eigen::MatrixXd body;
  Eigen::MatrixXd read;
  Eigen::VectorXd force_n;
  Eigen::VectorXd activity;
  Eigen::VectorXd air_degc;
  Eigen::VectorXd pressure_hpa;
  Eigen::VectorXd humidity_pct;
  // True rotations rx, ry, rz that nobody commanded, arcsec.
  Eigen::MatrixXd tilt;

  bool has_force = false;
  bool has_activity = false;
  bool has_tilts = false;
  bool has_air = false;
  bool has_times = true;
  bool has_sets = true;
  bool has_dwell = true;
  bool has_lines = true;
  bool has_runs = true;
  bool force_offered = false;

  // Linear laws that the baseline contains, normalised motor units per K and per N.
  Eigen::MatrixXd thermal;
  Eigen::VectorXd compliance;
  // Degree of the baseline's geometry, and the thermometers it offers.
  int degree = 1;
  std::vector<int> offered;

  std::vector<int> calibration;
  std::vector<int> validation;

  int rows() const { return static_cast<int>(time_s.size()); }
  int thermometer_count() const { return static_cast<int>(thermometers.size()); }

  // Pose (mm, arcsec) of all rows when the motors are off by dq (their unit) and the instruments by
  // dp (unit of the pose), with these temperatures in the thermal law.
  Eigen::MatrixXd pose(const Eigen::MatrixXd& dq, const Eigen::MatrixXd& dp,
                       const Eigen::MatrixXd& temperature) const;
  // Normalised motor values of all rows less what moves the robot without them: motor errors, heat
  // and force. Each is the baseline's polynomial of the row's pose.
  Eigen::MatrixXd acting_motors(const Eigen::MatrixXd& dq,
                                const Eigen::MatrixXd& temperature) const;
  // Largest gap of a row between the polynomial of its pose and its acting motor values.
  double largest_gap(const Eigen::MatrixXd& pose, const Eigen::MatrixXd& acting) const;
  // Difference of two pose tables as the baseline sees it: taken through the motors' geometry and
  // back through its linear part, so that what is linear in the motors stays so. Unit of the pose.
  Eigen::MatrixXd effect(const Eigen::MatrixXd& with, const Eigen::MatrixXd& without) const;
  // Normalised true pose without hidden effect.
  Eigen::MatrixXd clean_u() const;
  // Columns that the stated baseline offers, with the constant, in the order of the rows.
  Eigen::MatrixXd design(const Eigen::MatrixXd& temperature) const;
  Eigen::MatrixXd no_motor_error() const { return Eigen::MatrixXd::Zero(rows(), robot.axes); }
  Eigen::MatrixXd no_pose_error() const { return Eigen::MatrixXd::Zero(rows(), robot.axes); }
};

// Throws std::runtime_error where the drawn robot is no machine (regular_in_stroke): it is drawn
// again with the next attempt of the order.
Campaign make_campaign(const CampaignChoice& choice, const Needs& needs, Random& random);

}  // namespace driftwise::foreign
