#pragma once
// The dataset as a search sees it: temperatures smoothed, and positions by the places they belong
// to, from which periodic columns are taken. Positions sit on a lattice, so a wave over the
// *measured* one, through zero at every place, reads the measurement's own noise back out
// (NUMERICS.md section 3). Motor coordinates are taken at their places, pose coordinates as the
// motors predict them (problem.cc). Play and creep read their motor's own path back in the
// same way, which matters where moves are short: they run on the path that the simulation predicts.

#include <Eigen/Core>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/core/result.h"
#include "server/diagnosis/rows/coarse_readings.h"
#include "server/effects/term.h"

namespace driftwise::diagnosis {

class Prepared {
 public:
  static Prepared of(const Dataset& dataset);

  // The path of a motor coordinate as the simulation predicts it, one value per row.
  void set_path(const std::string& symbol, const std::vector<double>& values);
  // A pose coordinate as the motors predict it (predicted_pose.h): every column from here on reads
  // it instead of the measured one.
  void set_coordinate(const std::string& symbol, const std::vector<double>& values);

  // Temperatures that change as fast as the rows, and that the outputs follow, as they were read or
  // as near to it as share_followed() says (smoothing.h). base_columns: of every row; outputs: of
  // the rows that learn. True: some were given back.
  bool give_back_followed(const std::vector<effects::Term>& base,
                          const Eigen::MatrixXd& base_columns, const Eigen::MatrixXd& outputs,
                          const std::vector<std::size_t>& rows);

  // What causes read: conditions smoothed, coordinates predicted.
  const Dataset& conditions() const { return clocked_; }

  const Dataset& data() const { return data_; }
  // Path of the motors: what their plays and creeps go with.
  const Dataset& path() const { return on_path_; }
  // Channels that are read in coarse steps, by symbol.
  const std::map<std::string, CoarseChannel>& coarse() const { return coarse_; }
  // Every row's value of every term. Untimed data count their rows: whoever asks knows which terms
  // may be asked. A rate(T, tau s) over no more than a step and a half of the rows is the
  // derivative at the row: the filter of the formula takes noise out and is late by tau for it, and
  // the temperatures here are smooth already. Over no more than three quarters of a step it is the
  // derivative of the readings: a cycle of the room that is nearly as fast as the rows goes with
  // the noise where they are smoothed.
  Result<Eigen::MatrixXd> columns(const std::vector<effects::Term>& terms) const;
  // What a wave's phase goes with: an axis or motor in mm at its places; "" for the clock in s.
  std::span<const double> phase_values(const std::string& symbol) const;

 private:
  Dataset readings_, data_, clocked_, at_places_, on_path_;
  std::map<std::string, CoarseChannel> coarse_;
  double step_s_ = 0;  // typical, between rows
};

}  // namespace driftwise::diagnosis
