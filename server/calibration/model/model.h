#pragma once
// A model: an immutable fit result. motor coordinate = sum over terms of coefficient * term(raw
// channel values), in the units of the columns. What compensation, exports and comparisons start
// from.

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/core/channel.h"
#include "server/core/data/accuracy.h"
#include "server/core/data/measured_by.h"
#include "server/core/data/reading.h"
#include "server/core/description/kinematics_description.h"
#include "server/core/ids.h"
#include "server/effects/term.h"

namespace driftwise::calibration {

struct TermReport {  // one per offered term, the constant first
  effects::Term term;
  bool in = false;
  double coefficient = 0, standard_error = 0, t = 0,
         p = 1;  // an outside term: as if it alone were added
  // In terms only, from here. Allowing for rows that are not independent: serial_errors.h.
  double standard_error_serial = 0;
  double vif = 0;
  double contribution_rms = 0,
         contribution_max = 0;              // over the calibration rows about its mean, column unit
  std::vector<std::string> replaceable_by;  // terms outside that would do instead of this one, at
                                            // less than 1 % more residual variance
  std::string note;  // "" or why it could not be tried: "cannot be told apart from x^2"
};

struct SelectionStep {
  int step = 0;
  std::string action;  // "start", "enter", "remove"
  effects::Term term;
  double p = 1, rmse = 0;
  int dof = 0;
  std::optional<double> value = {};  // of BIC or AIC after the step, where that is the criterion
};

struct StartOutcome {  // of one of several starts of a selection: starts.h
  std::string name;    // "none", "all", "random 3"
  int began_with = 0;  // terms in at the start; constants are not counted
  int ended_with = 0;
  double rmse = 0;              // column unit
  std::optional<double> value;  // BIC, or AIC with that criterion; none: an exact fit
  bool won = false;
};

// Figures of one named validation set (server/formats/csv/set_names.h), column unit.
struct SetAccuracy {
  std::string name;  // "inside"; "validation" for validation rows without a name beside named ones
  ErrorFigures figures;
};

// Of one output, column unit. mean, U90 and A90 as server/core/data/accuracy.h computes them: each
// U90 has its mean, each A90 holds it.
struct Accuracy {
  double rmse = 0;             // residual standard deviation, sqrt(RSS / dof)
  double u90_calibration = 0;  // of the calibration residuals
  double mean_calibration = 0, a90_calibration = 0;
  std::optional<double> u90_validation, mean_validation, a90_validation;  // rows marked validation
  std::optional<double> u90_blocks, mean_blocks, a90_blocks;  // held out by blocks of time
  std::optional<double> u90_blocks_low, u90_blocks_high;      // 90 % intervals over the blocks
  std::optional<double> a90_blocks_low, a90_blocks_high;
  std::optional<double> block_count;  // of those intervals; none: of a model from before 2026-12
  double lag1_autocorrelation = 0, effective_rows = 0;
  // Residuals in time order: the share of their variance that is slow, and over how many rows it
  // keeps (serial_noise.h). 0: white.
  double slow_share = 0, slow_rows = 0;
  std::optional<double> pure_error;  // from repeated poses
  std::optional<double> lack_of_fit_f, lack_of_fit_p;
  double condition_index =
      0;  // of the terms in, columns at unit length (Belsley); above 30: look-alikes
  std::optional<double> model_f, model_p;  // all terms in against the constant alone
  std::optional<double> aic, bic;          // criterion.h; none where the terms reproduce every row
  // By name, in the order of their first row; empty: the validation rows have no names.
  std::vector<SetAccuracy> validation_sets;
};

// What a systematic error of one measured channel did to the fit: the model as served is f - shift
// for an error of 1 (server/calibration/report/influence.h).
struct Influence {
  std::string channel;  // in error: "x_mm", "t07_degC"
  std::string by;       // what the error goes with, row by row: "1" (an offset), "y_mm",
                        // "ry_arcsec", "h" (hours since the zero), "t04_degC" (kelvin
                        // since the zero), "zero" (the reading at the zero, as
                        // far as the rows still have its error)
  double rms = 0;       // of the error that 1 of it makes in the output, over the calibration rows
  Eigen::VectorXd shift;  // of the coefficients, for 1 of it; output's unit
};

constexpr std::size_t kMostHeldOutRows = 20'000;  // whose errors a model keeps, row by row

struct OutputModel {
  Channel channel;                   // q1_mm
  std::vector<effects::Term> terms;  // those in; the constant first where there is one
  Eigen::VectorXd coefficients;      // same order
  Eigen::MatrixXd covariance;        // of the coefficients, same order, column units
  int dof = 0;
  Accuracy accuracy;
  Eigen::MatrixXd covariance_serial;  // allowing for rows that are not independent
                                      // (serial_errors.h); empty: not known
  // W, with W W' the covariance that targets count with, column units: a variance a'C a is the sum
  // of the squares of W'a, which needs the digits that the coefficients need and never is negative.
  // a'C a itself needs twice as many. Empty: a model of before, or one without degrees of freedom.
  Eigen::MatrixXd covariance_root;
  double noise_variance = 0;  // of one row, with what the terms took up of it (noise_spectrum.h);
                              // column unit squared; 0: not known
  std::vector<Influence> influences;
  // Per row of the dataset, column unit: the residual of a row marked validation, the error of a
  // calibration row as predicted without its block of time; NaN where a row has neither. What
  // u90_, mean_ and a90_ of validation and blocks are computed from. Empty: a file of more than
  // kMostHeldOutRows rows, or nothing was held out.
  std::vector<double> held_out;
  std::vector<TermReport> report;
  std::vector<SelectionStep> history;
  std::vector<StartOutcome> starts;  // empty: there was one, from none
};

struct ChannelRange {
  Channel channel;
  double min = 0, max = 0;
};

// A datum but the first of a fit (datum_zeros.h).
struct DatumZero {
  int ordinal = 2;                 // the k of its datum(k)
  std::vector<ChannelValue> pose;  // where its pose 0 lies in the first datum's frame, "x_mm" ...,
                                   // units of the columns; empty: not moved
  std::string why_not;             // a clause: why it has its constant alone
};

struct Lineage {
  std::vector<RunId> runs;  // empty: a file
  std::string source;       // file name, or "runs 3, 4"
  std::string dataset_hash;
  std::int64_t rows_calibration = 0, rows_validation = 0, rows_dropped = 0;
  std::int64_t rows_excluded = 0;  // kept out on a person's word
  std::string exclusions_hash;     // which rows those are; empty: none
  std::optional<ModelId> parent;
  // Which instruments gave the coordinates of the pose; one that is not here has one instrument
  // only, or nothing said which.
  std::vector<MeasuredBy> measured_by;
};

// One number of a robot's geometry.
struct GeometryParameter {
  std::string name;           // "link2.a_mm": as the robot file writes it
  double value = 0;           // in the unit that the name ends in
  double standard_error = 0;  // 0 where it is held
  bool free = false;
  std::string note;  // why it is held; how weakly it is determined
};

// A robot's own geometry (server/kinematics). A model with one gives
//   motor coordinate = geometry(pose) + sum over the output's terms
// or, of a serial arm, whose geometry gives the pose, the joint angles that bring it there; its
// outputs are then x, y, z and have figures and no terms.
struct Geometry {
  KinematicsDescription robot;                // its numbers are the model's
  std::vector<GeometryParameter> parameters;  // empty: imported, nothing was identified
  Eigen::MatrixXd covariance;                 // of the free ones, in their order and units
  // Shifts of the free parameters by errors of the measured pose, in their order and units. The
  // same errors, in the same order, are in every output's influences, with the shift of its terms.
  std::vector<Influence> influences = {};
};

struct Model {
  std::string formula;              // canonical
  std::string select = "stepwise";  // or "all"
  std::string criterion = "p";      // "p", "bic", "aic"
  double p_enter = 0.05, p_remove = 0.10;
  bool hierarchy = false;
  int starts = 1;         // of the selection
  std::int64_t seed = 1;  // of the random starts
  std::vector<OutputModel> outputs;
  std::vector<ChannelRange> domain;    // of every channel used by a term, over the calibration rows
  std::vector<DatumZero> datum_zeros;  // of every further datum; poses of their rows are moved by
                                       // them before a term sees them (in_first_datum())
  Lineage lineage;
  std::vector<std::string> warnings;
  double fit_us = 0;
  std::optional<Geometry> geometry = {};  // none: terms alone
};

}  // namespace driftwise::calibration
