#pragma once
// What a model says about the rows of a dataset: the same evaluator, the same sum, that
// compensation serves from.

#include <Eigen/Core>

#include "server/calibration/model/executor.h"
#include "server/calibration/model/model.h"
#include "server/core/data/dataset.h"
#include "server/core/result.h"

namespace driftwise::calibration {

// The output at every row of the dataset, in the output's unit; NaN where a value is missing.
// datum(k) terms apply to the dataset's k-th datum. Effects with memory run over all rows, in
// order. Errors: those of effects::TermEvaluator::create; invalid_argument UNTIMED.
Result<Eigen::VectorXd> predict(const Dataset& dataset, const OutputModel& output,
                                const Executor& executor = {});

// The same, and how each term, raw, ranges over some of the rows (ascending).
struct TermRange {
  double low = 0, high = 0, mean = 0;
};
struct PredictedRows {
  Eigen::VectorXd output;
  std::vector<TermRange> terms;
};
Result<PredictedRows> predict_and_range(const Dataset& dataset, const OutputModel& output,
                                        const std::vector<std::size_t>& rows,
                                        const Executor& executor);

// sum of coefficients[j] * columns(row, j), left to right.
Eigen::VectorXd combine(const Eigen::MatrixXd& columns, const Eigen::VectorXd& coefficients);

// Every row's value of every term, raw. Large: rows x terms.
Result<Eigen::MatrixXd> raw_columns(const Dataset& dataset,
                                    const std::vector<effects::Term>& terms);

}  // namespace driftwise::calibration
