#pragma once
// Errors of rows that a method did not see, fold by fold: what every held-out figure of this room
// is computed from.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "server/identification/folds.h"
#include "server/identification/method.h"

namespace driftwise::identification {

// Rows of a set that are not kept out, ascending.
std::vector<std::size_t> rows_in(const Dataset& dataset, PointSet set);

// Validation rows whose zero a model can know: their datum has one of the calibration rows.
std::vector<std::size_t> validation_rows_known(const Dataset& dataset,
                                               const std::vector<std::size_t>& calibration);

// rows x outputs. Errors: internal NO_OUTPUT.
Result<Eigen::MatrixXd> measured_outputs(const Dataset& dataset,
                                         const std::vector<Channel>& outputs);

// One output's values at some rows.
Eigen::VectorXd picked(const Eigen::MatrixXd& values, const std::vector<std::size_t>& rows,
                       Eigen::Index output);

// Errors of the rows held out, column unit: [fold][output].
using FoldErrors = std::vector<std::vector<Eigen::VectorXd>>;

// dataset and options must outlive the bench.
struct Bench {
  const Dataset& dataset;
  Method method;
  const MethodOptions& options;
  Eigen::MatrixXd measured;  // measured_outputs()

  // Fits on fold.train alone, whatever set its rows are of, and predicts fold.test. Rows of a datum
  // that is not in the training count as calibration::judge_untrained() has them, one row of such a
  // datum not at all. Errors: those of fit_method.
  Result<std::vector<Eigen::VectorXd>> errors_of(const Fold& fold) const;
  // Of all folds, shared out by the options' executor. Empty where a fold cannot be fitted; the
  // reason is left in warnings.
  FoldErrors errors_of(const std::vector<Fold>& folds, const std::string& what,
                       std::vector<std::string>& warnings) const;
};

}  // namespace driftwise::identification
