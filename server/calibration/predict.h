#pragma once
// What a model says about the rows of a dataset: the same evaluator, the same sum, that
// compensation serves from.

#include <Eigen/Core>

#include "server/calibration/model.h"
#include "server/core/dataset.h"
#include "server/core/result.h"

namespace driftwise::calibration {

// The output at every row of the dataset, in the output's unit; NaN where a value is missing.
// datum(k) terms apply to the dataset's k-th datum. Effects with memory run over all rows, in
// order. Errors: those of effects::TermEvaluator::create; invalid_argument UNTIMED.
Result<Eigen::VectorXd> predict(const Dataset& dataset, const OutputModel& output);

// sum of coefficients[j] * columns(row, j), left to right.
Eigen::VectorXd combine(const Eigen::MatrixXd& columns, const Eigen::VectorXd& coefficients);

// Every row's value of every term, raw. Large: rows x terms.
Result<Eigen::MatrixXd> raw_columns(const Dataset& dataset,
                                    const std::vector<effects::Term>& terms);

}  // namespace driftwise::calibration
