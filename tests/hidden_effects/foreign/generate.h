#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/hidden_effects/foreign/campaign.h"
#include "tests/hidden_effects/foreign/hidden.h"
#include "tests/hidden_effects/foreign/readings.h"
#include "tests/hidden_effects/foreign/rivals.h"

namespace driftwise::foreign {

// What is to be made. Empty strings are drawn from the seed.
struct Order {
  std::uint64_t seed = 1;
  // null, single, pair, unlisted.
  std::string kind = "null";
  std::string cause;
  double chi2 = 150.0;
  // all, none, robot, plan, noise, sensors, units; "cycle": 70 % of the seeds all, the others one
  // thing.
  std::string vary = "cycle";
  std::string robot;
  std::string plan;
  std::string noise;
  // study (mm, arcsec, degC, tNN), random, or auto: as `vary` says.
  std::string units = "auto";
  bool reserved = false;
};

// One hidden mechanism as it came out.
struct Truth {
  std::string cause;
  std::string subject;
  std::map<std::string, double> parameters;
  double chi2 = 0.0;
  // Strength beyond the other mechanism of a pair.
  double chi2_beyond_other = 0.0;
  // Part of chi2 that the true cause explains with columns of the file's readings (strength.h), one
  // by one and smoothed over the rows. Of catalogue causes only.
  double chi2_in_readings = 0.0;
  double chi2_in_smoothed_readings = 0.0;
  bool identifiable = true;
  // Subjects of the same cause within 20 in 2 ln L.
  std::vector<std::string> subjects;
  // Other causes within 20 in 2 ln L, and the nearest of all.
  std::vector<Rival> set;
  std::vector<Rival> nearest;
};

// A data set: the campaign, the readings with effect and noise, and the truth about them.
struct Generated {
  Order order;
  std::string varied;
  Campaign campaign;
  Eigen::MatrixXd pose;
  Eigen::MatrixXd read;
  Eigen::MatrixXd tilt_read;
  // Error of the pose against the baseline's law: effect and noise, unit of the pose.
  Eigen::MatrixXd error;
  Eigen::MatrixXd effect;
  // Without noise: where the end-effector is in every row, and what the instruments add to it. Unit
  // of the pose.
  Eigen::MatrixXd true_pose;
  Eigen::MatrixXd instrument_error;
  // Of each instrument at pose 0 in the conditions of the first row: a datum zeroed there counts
  // from it.
  Eigen::VectorXd error_at_zero;
  std::vector<Truth> truths;
  // Catalogue causes as they were planted, in the order of `truths`.
  std::vector<Planted> planted;
  // Causes that are named rightly though nothing was hidden (spread that depends on place or hour).
  std::vector<std::string> allowed;
  int attempts = 1;
};

// Data set of an order. The same order gives the same data on every machine.
// Throws std::runtime_error when no attempt (40) gives the wanted strength within what machines do.
Generated generate(const Order& order);

// Rms of what a least-squares fit of the baseline leaves on other rows, per pose coordinate.
Eigen::VectorXd held_out_rms(const Campaign& campaign, const Eigen::MatrixXd& read,
                             const Eigen::MatrixXd& error);

}  // namespace driftwise::foreign
