#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/hidden_effects/foreign/campaign.h"

namespace driftwise::foreign {

// Errors that a mechanism makes: dq in the unit of each motor, dp in the unit of each pose
// coordinate, and thermometer readings as the table shows them (empty: as they were read).
struct Errors {
  Eigen::MatrixXd dq;
  Eigen::MatrixXd dp;
  Eigen::MatrixXd read;
};

// A hidden mechanism with free strength.
struct Hidden {
  std::string cause;
  // Symbol of the subject in study names: "q2", "x", "t03", "F", "" for none.
  std::string subject;
  std::map<std::string, double> parameters;
  // Errors at an amplitude; most mechanisms are linear in it.
  std::function<Errors(double)> errors;
  // Error of each instrument per unit of amplitude at pose 0, in the conditions of the first row.
  // Empty: none.
  Eigen::VectorXd at_zero;
  // First amplitude to try, and the largest that a machine has.
  double start = 1.0;
  double largest = 1e300;
  // Name of the amplitude in the key.
  std::string amplitude_name = "amplitude";
  // For noise_change: rows from here on (in pose coordinate `noise_axis`) have spread x amplitude.
  int noise_from_row = -1;
  int noise_axis = 0;
};

// Catalogue entries that this generator can hide in a table.
const std::vector<std::string>& cause_ids();
// Those that an untimed table can show.
bool needs_time(const std::string& cause);
Needs cause_needs(const std::string& cause);

// The mechanism with parameters drawn. Throws std::runtime_error if this campaign cannot show it.
Hidden draw_cause(const std::string& cause, const Campaign& campaign, Random& random);

// Mechanisms in no catalogue.
const std::vector<std::string>& unlisted_ids();
Needs unlisted_needs(const std::string& id);
Hidden draw_unlisted(const std::string& id, const Campaign& campaign, Random& random);

// Study name of thermometer k: t01, t02, ...
std::string thermometer_symbol(int k);

}  // namespace driftwise::foreign
