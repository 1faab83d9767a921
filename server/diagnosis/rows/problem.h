#pragma once
// A dataset laid out for the search: which rows learn, which judge, each output in its summary unit
// with the baseline's columns.
//
// Long data are averaged over blocks of neighbouring rows. Averages are taken of the measured
// values and of the finished columns, never of channels: a linear model of averages is the average
// of the model, whatever the columns are.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "server/calibration/fit.h"
#include "server/core/data/dataset.h"
#include "server/core/result.h"
#include "server/diagnosis/noise/noise_model.h"
#include "server/diagnosis/rows/prepared.h"

namespace driftwise::diagnosis {

// Rows that a search looks at one by one; more of them are averaged (Problem::lay_blocks).
inline constexpr std::size_t kMostSearched = 4000;

struct ProblemOutput {
  Channel channel;
  std::string unit;          // summary unit
  double factor = 1;         // summary unit per channel's unit
  Eigen::VectorXd measured;  // every row, in the summary unit; at the predicted pose (problem.cc)
  // Sides that `measured` was freed of, every row (two_sides.h). No prediction knows them, so
  // figures are of the readings as they were. Empty: nothing.
  Eigen::VectorXd freed_of{};
  // Part that the search takes off the rows that learn, for their noise has heavy tails
  // (DataFaults::tame_tails); `measured` has it. Empty: nothing.
  Eigen::VectorXd tails{};
};

// Rows that one fit of the held-out figures learns from, and those it is judged on.
struct Fold {
  std::vector<std::size_t> learn, judge;
};

// Noise that coarse readings of the baseline's channels hide: columns, each with an amplitude about
// zero.
struct Hidden {
  Eigen::MatrixXd columns;  // every row of the dataset
  Eigen::MatrixXd sd;       // columns x outputs, in the output's summary unit
};

struct Problem {
  Prepared prepared;
  std::vector<std::size_t> learn;  // complete rows that the search works on, in time order
  std::vector<std::size_t> judge;  // rows with a held-out figure: of all folds, in time order
  std::vector<Fold> folds;
  std::size_t rows_per_block = 1;
  std::vector<std::size_t> block_of;  // of each learning row
  Timeline timeline;                  // of the blocks
  // Spread of every dataset row's noise over the others', rows x outputs; empty: all alike.
  Eigen::MatrixXd row_sd;
  std::vector<ProblemOutput> outputs;
  // In the frame of the coordinates: the motors (search/coordinate_frame.h). Empty: the outputs.
  std::vector<std::string> given_outputs{};
  std::vector<effects::Term> base;          // the constant and further datums first
  Eigen::MatrixXd base_columns;             // every row of the dataset, raw, at the predicted pose
  Hidden hidden;                            // what coarse thermometers of the baseline hide
  std::vector<effects::Term> undetermined;  // of the baseline, left out: calibration/undetermined.h
  bool judged_by_validation = false;
  bool judged_in_turn = false;  // each block of time by a fit to the others; else rows kept apart

  const Dataset& data() const { return prepared.data(); }
  std::vector<std::string> output_symbols() const;
  // One row per block of learning rows: the mean of every column. all: one row per dataset row.
  Eigen::MatrixXd learned(const Eigen::MatrixXd& all) const;
  // Readings of every output, one row per block of learning rows: rows x outputs, summary units.
  Eigen::MatrixXd series() const;
  // The same without their tails.
  Eigen::MatrixXd searched() const;
  // From here on the rows of one output, or of all, count by this spread as well: every dataset
  // row.
  void spread_rows(const Eigen::VectorXd& sd, std::optional<std::size_t> output);
  // Leaves these rows of the dataset out of learning and judging.
  void leave_out(const std::vector<std::size_t>& rows);
  // Blocks and timeline from `learn`; longest: blocks at most.
  void lay_blocks(std::size_t longest);
};

// Held-out rows of a dataset that marks none as validation.
enum class Judging {
  in_turn,  // each of ten blocks of time, by a fit to the others; the search works on all rows
  apart     // two of ten blocks of time, which take no part in anything else
};

// Is it a pose coordinate of the robot: a length, or an angle that the baseline reads? A tilt that
// it does not read is an instrument's reading.
bool is_coordinate(const Problem& problem, const Channel& channel);

// Has the row every output, and a value of every term of the baseline?
bool is_complete(const Problem& problem, std::size_t row);

Eigen::MatrixXd rows_of(const Eigen::MatrixXd& columns, const std::vector<std::size_t>& rows);

// Rows marked validation are held out, but those of a datum without calibration rows: nothing knows
// their constant. Where none is left, those that `judging` says.
// longest: blocks that the search works with at most. The problem is in the catalogue's units
// (catalogue_units.h), whatever the dataset is in.
// Errors: invalid_argument UNKNOWN_CHANNEL, NO_OUTPUT, TOO_FEW_ROWS, TIME_RUNS_BACK, UNTIMED,
// NOTHING_VARIES.
Result<Problem> lay_out(const Dataset& dataset, const calibration::Candidates& baseline,
                        std::size_t longest, Judging judging = Judging::in_turn);

}  // namespace driftwise::diagnosis
