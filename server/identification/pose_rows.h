#pragma once
// The rows of a dataset as a mechanism sees them.

#include <Eigen/Core>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/effects/term.h"
#include "server/kinematics/mechanism.h"

namespace driftwise::identification {

// The channels of a mechanism out of a dataset, over all of its rows.
struct MechanismData {
  Eigen::MatrixXd inputs;   // inputs x rows: one row's inputs lie together
  Eigen::MatrixXd outputs;  // rows x outputs
};

// Errors: invalid_argument UNKNOWN_CHANNEL (one that the mechanism needs and the data lack),
// WRONG_UNIT.
Result<MechanismData> mechanism_data(const Dataset& dataset,
                                     const kinematics::Mechanism& mechanism);

// The mechanism's outputs on every row, rows x outputs; NaN where a value is missing or out of
// reach.
Eigen::MatrixXd predict_rows(const kinematics::Mechanism& mechanism, const Eigen::MatrixXd& inputs,
                             const Eigen::VectorXd& values);

// Which rows of a set have a number in every column asked for; excluded rows have not.
std::vector<std::size_t> complete_rows(const Dataset& dataset, PointSet set,
                                       const std::vector<const Eigen::MatrixXd*>& by_row);

// Marks as excluded every row in which one of the channels has no number, so that all methods see
// the same rows. Channels the data lack are passed over.
Dataset without_incomplete_rows(Dataset dataset, const std::vector<std::string>& symbols);

}  // namespace driftwise::identification
