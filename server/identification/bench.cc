#include "server/identification/bench.h"

#include <map>
#include <set>

#include "server/calibration/design/design.h"
#include "server/calibration/report/held_out_figure.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::identification {

using Eigen::Index;

std::vector<std::size_t> rows_in(const Dataset& dataset, PointSet set) {
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < dataset.rows; ++row)
    if (dataset.set_of(row) == set && !dataset.is_excluded(row)) rows.push_back(row);
  return rows;
}

std::vector<std::size_t> validation_rows_known(const Dataset& dataset,
                                               const std::vector<std::size_t>& calibration) {
  const auto datums = calibration::datum_ordinals(dataset);
  std::set<double> known;
  for (const std::size_t row : calibration) known.insert(datums[row]);
  std::vector<std::size_t> rows;
  for (const std::size_t row : rows_in(dataset, PointSet::validation))
    if (known.contains(datums[row])) rows.push_back(row);
  return rows;
}

Result<Eigen::MatrixXd> measured_outputs(const Dataset& dataset,
                                         const std::vector<Channel>& outputs) {
  Eigen::MatrixXd measured(static_cast<Index>(dataset.rows), static_cast<Index>(outputs.size()));
  for (std::size_t o = 0; o < outputs.size(); ++o) {
    const DatasetColumn* column = dataset.find(outputs[o].symbol);
    if (column == nullptr)
      return fail(ErrorCode::internal, reasons::kNoOutput, "no column " + outputs[o].name());
    measured.col(static_cast<Index>(o)) = Eigen::Map<const Eigen::VectorXd>(
        column->values.data(), static_cast<Index>(column->values.size()));
  }
  return measured;
}

Eigen::VectorXd picked(const Eigen::MatrixXd& values, const std::vector<std::size_t>& rows,
                       Index output) {
  Eigen::VectorXd some(static_cast<Index>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i)
    some[static_cast<Index>(i)] = values(static_cast<Index>(rows[i]), output);
  return some;
}

namespace {

// Of each of the rows.
std::vector<int> datums_of(const std::vector<double>& ordinals,
                           const std::vector<std::size_t>& rows) {
  std::vector<int> datums;
  for (const std::size_t row : rows) datums.push_back(static_cast<int>(ordinals[row]));
  return datums;
}

}  // namespace

Result<std::vector<Eigen::VectorXd>> Bench::errors_of(const Fold& fold) const {
  Dataset part = dataset;
  part.set.assign(part.rows, PointSet::calibration);
  part.excluded.assign(part.rows, 1);
  for (const std::size_t row : fold.train) part.excluded[row] = 0;
  MethodOptions quick = options;
  quick.fit.blocks = 0;
  quick.fit.first_rows = 0;
  quick.fit.stopwatch_us = {};
  quick.fit.executor = {};  // the folds are what is shared out
  DRIFTWISE_TRY(const auto fitted, fit_method(part, method, quick));
  DRIFTWISE_TRY(const auto predicted, predict(dataset, fitted));
  const auto ordinals = calibration::datum_ordinals(dataset);
  const auto known = datums_of(ordinals, fold.train), datums = datums_of(ordinals, fold.test);
  const std::set<int> trained(known.begin(), known.end());
  std::map<int, int> rows_of;
  for (const int datum : datums) ++rows_of[datum];
  std::vector<Index> judged;  // a datum of one row, untrained, says nothing of that row
  for (std::size_t i = 0; i < datums.size(); ++i)
    if (trained.contains(datums[i]) || rows_of[datums[i]] > 1)
      judged.push_back(static_cast<Index>(i));
  std::vector<Eigen::VectorXd> errors;
  for (Index o = 0; o < measured.cols(); ++o) {
    Eigen::VectorXd all = picked(measured - predicted, fold.test, o);
    calibration::judge_untrained(datums, trained, all);
    errors.emplace_back(all(judged));
  }
  return errors;
}

FoldErrors Bench::errors_of(const std::vector<Fold>& folds, const std::string& what,
                            std::vector<std::string>& warnings) const {
  FoldErrors all(folds.size());
  std::vector<std::string> whys(folds.size());
  calibration::run_on(options.fit.executor, folds.size(), [&](std::size_t f) {
    auto errors = errors_of(folds[f]);
    if (errors)
      all[f] = std::move(*errors);
    else
      whys[f] = errors.error().message;
  });
  for (const auto& why : whys) {
    if (why.empty()) continue;
    warnings.push_back(name_of(method) + ": no held-out figure " + what + ": " + why);
    return {};
  }
  return all;
}

}  // namespace driftwise::identification
