#pragma once
// Identification of a robot's own parameters by nonlinear least squares: lengths, angles, offsets
// and where it stands in the measuring frame, together with linear terms of force and temperature
// where they are offered.
//
//   output = mechanism(inputs; parameters) + constant + sum of coefficient * term
//
// The geometry stands in the first datum of the rows: datum(k) is what a further one lies apart,
// and the constant is 0 but for the offered terms, which are counted from their means.
//
// Every output counts alike in the solution; parameters are scaled by what a deviation of each is
// worth (kinematics::Parameter::natural). What cannot be told apart by such data about the drawing
// is held at its nominal value and named (identifiability.h). docs/kinematics.md.

#include <memory>
#include <span>

#include "server/calibration/model/model.h"
#include "server/core/data/dataset.h"
#include "server/kinematics/mechanism.h"

namespace driftwise::identification {

struct IdentifyOptions {
  std::shared_ptr<const kinematics::Mechanism> mechanism;
  std::vector<effects::Term> terms;  // linear in every output; those that read the mechanism's
                                     // inputs are left to the mechanism
  bool placement_only = false;       // the nominal robot: only where it stands, or reads zero
};

struct IdentifiedParameter {
  kinematics::Parameter parameter;
  double value = 0;
  double standard_error = 0;  // 0 where it is held
  bool free = false;
  std::string note;  // why it is held; how weakly it is determined
};

struct Identification {
  std::shared_ptr<const kinematics::Mechanism> mechanism;
  std::vector<IdentifiedParameter> parameters;
  std::vector<effects::Term> terms;  // the constant first, then datum(k), then those offered; none
                                     // where none was offered and there is one datum
  std::vector<effects::Term> undetermined;  // offered, and left out: calibration/undetermined.h
  Eigen::MatrixXd coefficients;             // terms x outputs
  Eigen::MatrixXd standard_errors;          // terms x outputs; 0 for the constant
  // J+ N J+' with the noise of each output as its residuals show it, in size and from row to row
  // (serial_covariance.h). Of the free parameters, in their order and units; of the terms of each
  // output, the constant's own share (it is the parameters') left out.
  Eigen::MatrixXd covariance;
  std::vector<Eigen::MatrixXd> term_covariances;
  Eigen::VectorXd rss;    // per output, over the calibration rows
  std::int64_t rows = 0;  // calibration rows
  int unknowns = 0;       // parameters and coefficients estimated
  int evaluations = 0;
  double condition = 1;  // of the free parameters

  Eigen::VectorXd values() const;
  std::vector<char> free() const;
};

// On the complete rows marked calibration. Errors: invalid_argument UNKNOWN_CHANNEL, WRONG_UNIT;
// failed_precondition TOO_FEW_ROWS, BAD_START, NO_CONVERGENCE, POINTS_ON_A_LINE.
Result<Identification> identify(const Dataset& dataset, const IdentifyOptions& options);

// Means of the terms' columns (rows x terms), from which they count beside an identified geometry;
// of datum(k) 0, so that the geometry is that of the first datum.
Eigen::VectorXd term_means(std::span<const effects::Term> terms, const Eigen::MatrixXd& columns);

// rows x outputs, NaN where a value is missing.
Result<Eigen::MatrixXd> predict(const Dataset& dataset, const Identification& identification);

}  // namespace driftwise::identification
