#pragma once
// Influence of systematic errors of the measured pose, and of the force, on an identified geometry.
//
// The identification takes its rows at their word. With x wrong by h(row), the motor coordinates
// q = g(x; p) + terms are offered g(x + h), and to first order parameters and coefficients move
// together by the least squares of -(dg/dx) h on the identification's own derivatives. The law is
// that of a regression (server/calibration/report/influence.h), with derivatives in place of terms.
// Of an arm the pose is what is predicted: with x read wrong by h, the least squares are those of
// h.

#include <string>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/core/result.h"
#include "server/identification/identify.h"

namespace driftwise::identification {

struct PoseInfluence {
  std::string channel, by;       // as in calibration::Influence
  Eigen::VectorXd rms;           // per output: of the error that 1 of it makes, over the rows
  Eigen::VectorXd parameters;    // shift of the free ones, in their order and units
  Eigen::MatrixXd coefficients;  // terms x outputs, as in Identification
};

// dataset: what was identified on. At most about 2000 rows are looked at, evenly spread. Errors:
// those of predict.
Result<std::vector<PoseInfluence>> pose_influences(const Dataset& dataset,
                                                   const Identification& identification);

// Puts them into a model that has the geometry and the outputs of the identification: those of the
// parameters, and with each output those of its terms. Errors: as above.
Result<void> add_pose_influences(const Dataset& dataset, const Identification& identification,
                                 calibration::Model& model);

}  // namespace driftwise::identification
