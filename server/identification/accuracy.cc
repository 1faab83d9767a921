#include "server/identification/accuracy.h"

#include <cmath>
#include <map>
#include <set>
#include <span>

#include "server/calibration/design/design.h"
#include "server/calibration/report/held_out_figure.h"
#include "server/calibration/report/residual_statistics.h"
#include "server/core/data/row_marks.h"
#include "server/core/data/unusable_values.h"
#include "server/core/try.h"
#include "server/core/units.h"
#include "server/effects/term_order.h"
#include "server/identification/bench.h"
#include "server/identification/pose_rows.h"

namespace driftwise::identification {
namespace {

using Eigen::Index;

std::vector<std::string> symbols_read(const MethodOptions& options) {
  std::vector<std::string> symbols = options.fit.candidates.outputs;
  for (const auto* terms : {&options.fit.candidates.terms, &options.fit.forced})
    for (const auto& term : *terms)
      for (const auto& symbol : effects::symbols_of(term)) symbols.push_back(symbol);
  if (options.mechanism)
    for (const auto* channels : {&options.mechanism->inputs(), &options.mechanism->outputs()})
      for (const auto& channel : *channels) symbols.push_back(channel.symbol);
  return symbols;
}

std::optional<calibration::HeldOut> of_output(const FoldErrors& folds, std::size_t output) {
  if (folds.empty()) return std::nullopt;
  std::vector<ErrorSums> sums;
  for (const auto& fold : folds) {
    auto& one = sums.emplace_back();
    for (const double error : fold[output]) one.add(error);
  }
  return calibration::held_out_figure(sums);
}

std::optional<double> position_rms(const FoldErrors& folds) {
  double squares = 0, rows = 0;
  for (const auto& fold : folds) {
    for (const auto& output : fold) squares += output.squaredNorm();
    rows += static_cast<double>(fold.front().size());
  }
  return rows > 0 ? std::optional(std::sqrt(squares / rows)) : std::nullopt;
}

// Standard deviation of one residual about the mean of its group, pooled.
std::optional<double> spread_within(const Eigen::VectorXd& residuals,
                                    const std::vector<std::size_t>& rows,
                                    const std::vector<int>& labels) {
  std::map<int, std::pair<double, int>> sums;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    auto& [sum, count] = sums[labels[rows[i]]];
    sum += residuals[static_cast<Index>(i)];
    ++count;
  }
  double squares = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto& [sum, count] = sums[labels[rows[i]]];
    squares += std::pow(residuals[static_cast<Index>(i)] - sum / count, 2);
  }
  const auto freedom = static_cast<double>(rows.size() - sums.size());
  return freedom < 3 ? std::nullopt : std::optional(std::sqrt(squares / freedom));
}

std::size_t newly_excluded(const Dataset& before, const Dataset& after) {
  std::size_t count = 0;
  for (std::size_t row = 0; row < after.rows; ++row)
    if (after.is_excluded(row) && !before.is_excluded(row)) ++count;
  return count;
}

bool one_unit(const std::vector<Channel>& outputs) {
  for (const auto& output : outputs)
    if (output.unit != outputs.front().unit) return false;
  return outputs.size() > 1;
}

void add_position(Judgement& result, const Eigen::MatrixXd& errors,
                  const std::vector<std::size_t>& calibration,
                  const std::vector<std::size_t>& validation, const FoldErrors& blocks,
                  const FoldErrors& groups) {
  PositionFigures position;
  position.unit = result.fitted.outputs.front().unit;
  const auto rms_of = [&errors](const std::vector<std::size_t>& rows) {
    double squares = 0;
    for (const std::size_t row : rows) squares += errors.row(static_cast<Index>(row)).squaredNorm();
    return std::sqrt(squares / static_cast<double>(rows.size()));
  };
  position.rms = rms_of(calibration);
  if (validation.size() >= 2) position.rms_validation = rms_of(validation);
  position.rms_blocks = position_rms(blocks);
  position.rms_groups = position_rms(groups);
  double pure = 0;
  for (const auto& output : result.outputs) {
    if (!output.pure_error)
      pure = std::nan("");
    else
      pure += *output.pure_error * *output.pure_error;
  }
  if (pure > 0) position.pure_error = std::sqrt(pure);
  result.position = position;
}

}  // namespace

Result<Judgement> judge_method(const Dataset& whole, Method method, const MethodOptions& options,
                               const JudgeOptions& judge) {
  if (const auto usable = without_unusable(whole)) {
    DRIFTWISE_TRY(auto judged, judge_method(usable->data, method, options, judge));
    judged.warnings.insert(judged.warnings.begin(), usable->sentence);
    return judged;
  }
  Dataset dataset = without_incomplete_rows(whole, symbols_read(options));
  const std::size_t left_out = newly_excluded(whole, dataset);
  if (options.fit.first_rows > 0)
    for (std::size_t row =
             end_of_first_rows(dataset, static_cast<std::size_t>(options.fit.first_rows));
         row < dataset.rows; ++row)
      if (dataset.set_of(row) == PointSet::calibration && !is_passage(dataset, row))
        dataset.excluded[row] = kExcludedRow;
  MethodOptions once = options;
  once.fit.blocks = 0;
  once.fit.first_rows = 0;
  DRIFTWISE_TRY(auto fitted, fit_method(dataset, method, once));
  DRIFTWISE_TRY(auto measured, measured_outputs(dataset, fitted.outputs));
  DRIFTWISE_TRY(const auto predicted, predict(dataset, fitted));
  const Eigen::MatrixXd errors = measured - predicted;

  const Bench bench{dataset, method, once, std::move(measured)};
  const auto calibration = rows_in(dataset, PointSet::calibration);
  const auto validation = validation_rows_known(dataset, calibration);
  Judgement result;
  if (left_out > 0)
    result.warnings.push_back(std::to_string(left_out) + " of " + std::to_string(whole.rows) +
                              " rows left out: a channel that is read has no value there");
  if (fitted.kinematics)
    for (const auto& term : fitted.kinematics->undetermined)
      result.warnings.push_back(name_of(method) + ": " + effects::notation(term) +
                                " is left out: the calibration rows do not tell it apart from the "
                                "terms before it");
  result.rows_calibration = static_cast<std::int64_t>(calibration.size());
  result.rows_validation = static_cast<std::int64_t>(validation.size());
  const FoldErrors blocks = bench.errors_of(time_folds(calibration, judge.blocks, judge.gap),
                                            "by blocks of time", result.warnings);
  FoldErrors groups;
  std::vector<int> labels;
  if (!judge.together.empty()) {
    DRIFTWISE_TRY(auto found, group_labels(dataset, judge.together));
    labels = std::move(found);
    std::set<int> distinct;
    for (const std::size_t row : calibration) distinct.insert(labels[row]);
    result.groups = static_cast<std::int64_t>(distinct.size());
    groups = bench.errors_of(group_folds(calibration, labels, judge.folds),
                             "with " + judge.together + " kept together", result.warnings);
  }
  for (std::size_t o = 0; o < fitted.outputs.size(); ++o) {
    const auto column = static_cast<Index>(o);
    const Eigen::VectorXd residuals = picked(errors, calibration, column);
    OutputFigures figures;
    figures.channel = fitted.outputs[o];
    figures.parameters = fitted.parameters(o);
    figures.rms = std::sqrt(residuals.squaredNorm() / static_cast<double>(residuals.size()));
    const auto figures_of = [](const Eigen::VectorXd& values) {
      return error_figures(std::span(values.data(), static_cast<std::size_t>(values.size())));
    };
    const ErrorFigures own = figures_of(residuals);
    figures.u90_calibration = own.u90;
    figures.mean_calibration = own.mean;
    figures.a90_calibration = own.a90;
    if (validation.size() >= 2) {
      const ErrorFigures held_out = figures_of(picked(errors, validation, column));
      figures.u90_validation = held_out.u90;
      figures.mean_validation = held_out.mean;
      figures.a90_validation = held_out.a90;
    }
    figures.blocks = of_output(blocks, o);
    figures.groups = of_output(groups, o);
    if (!labels.empty()) figures.pure_error = spread_within(residuals, calibration, labels);
    result.outputs.push_back(std::move(figures));
  }
  if (one_unit(fitted.outputs)) {
    result.fitted = std::move(fitted);
    add_position(result, errors, calibration, validation, blocks, groups);
  } else {
    result.fitted = std::move(fitted);
  }
  return result;
}

}  // namespace driftwise::identification
