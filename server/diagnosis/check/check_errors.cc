#include "server/diagnosis/check/check_errors.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "server/calibration/design/design.h"
#include "server/calibration/design/predict.h"
#include "server/calibration/model/model_units.h"
#include "server/calibration/pose_of_zero.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

using Eigen::Index;

// The terms that mean something in another datum: all but the constants of the model's own.
std::vector<Index> carried_terms(const calibration::OutputModel& output) {
  std::vector<Index> carried;
  for (std::size_t k = 0; k < output.terms.size(); ++k)
    if (!effects::datum_of(output.terms[k])) carried.push_back(static_cast<Index>(k));
  return carried;
}

const double* value_of(const std::vector<ChannelValue>& values, const std::string& channel) {
  for (const auto& value : values)
    if (value.channel == channel && !is_missing(value.value)) return &value.value;
  return nullptr;
}

// One row: the pose of the zero, everything else as the datum's record has it. None when it lacks
// something.
std::optional<Dataset> zero_row(const Dataset& data, const std::vector<effects::Term>& terms,
                                const std::vector<ChannelValue>& zero,
                                const std::vector<ChannelValue>& zero_pose) {
  Dataset row;
  row.rows = 1;
  row.time_s = {0};
  for (const auto& term : terms)
    for (const auto& symbol : effects::symbols_of(term)) {
      if (row.find(symbol)) continue;
      const auto* column = data.find(symbol);
      if (!column) return std::nullopt;
      double value = 0;
      if (is_pose_symbol(symbol)) {
        if (const double* moved = value_of(zero_pose, column->channel.name())) value = *moved;
      } else {
        const double* known = value_of(zero, column->channel.name());
        if (!known) return std::nullopt;
        value = *known;
      }
      row.columns.push_back({column->channel, {value}});
    }
  return row;
}

struct Anchor {  // of one datum
  double q = 0;  // column unit
  Eigen::RowVectorXd columns;
};

std::optional<Anchor> anchor_of(const calibration::OutputModel& output,
                                const std::vector<effects::Term>& terms, const Dataset& data,
                                const std::vector<ChannelValue>& zero,
                                const std::vector<ChannelValue>& zero_pose) {
  const double* q = value_of(zero, output.channel.name());
  const auto row = zero_row(data, terms, zero, zero_pose);
  if (!q || !row) return std::nullopt;
  const auto columns = calibration::raw_columns(*row, terms);
  if (!columns || !columns->allFinite()) return std::nullopt;
  return Anchor{*q, columns->row(0)};
}

// Where no zero is known: the middle of the datum's own rows.
Anchor middle_of(const Eigen::MatrixXd& columns, const std::vector<double>& q,
                 const std::vector<Index>& rows) {
  Anchor middle{0, Eigen::RowVectorXd::Zero(columns.cols())};
  for (const Index row : rows) {
    middle.q += q[static_cast<std::size_t>(row)] / static_cast<double>(rows.size());
    middle.columns += columns.row(row) / static_cast<double>(rows.size());
  }
  return middle;
}

const std::vector<ChannelValue>& poses_of(const RunToCheck& run, int ordinal) {
  static const std::vector<ChannelValue> kAtZero;
  const auto at = static_cast<std::size_t>(ordinal - 1);
  return at < run.zero_poses.size() ? run.zero_poses[at] : kAtZero;
}

// What every output needs of one datum to be compared with the model there.
struct Seen {
  std::vector<effects::Term> terms;
  Eigen::VectorXd coefficients;
  Dataset rows;                 // the zero alone, or the whole run
  std::vector<Index> of_datum;  // of rows: those to be met on average
  double q = 0;                 // there
};

// None: the output cannot be told there.
std::optional<Seen> seen_in(const calibration::OutputModel& output, const RunToCheck& run,
                            const std::vector<double>& ordinals, int ordinal) {
  Seen seen;
  const auto carried = carried_terms(output);
  for (const Index k : carried) seen.terms.push_back(output.terms[static_cast<std::size_t>(k)]);
  seen.coefficients = output.coefficients(carried);
  if (static_cast<std::size_t>(ordinal) <= run.zeros.size()) {
    const auto& zero = run.zeros[static_cast<std::size_t>(ordinal - 1)];
    const double* q = value_of(zero, output.channel.name());
    if (auto row = zero_row(run.data, seen.terms, zero, {}); q && row) {
      seen.rows = std::move(*row);
      seen.of_datum = {0};
      seen.q = *q;
      return seen;
    }
  }
  const auto* measured = run.data.find(output.channel.symbol);
  const auto columns = calibration::raw_columns(run.data, seen.terms);
  if (!measured || !columns) return std::nullopt;
  for (std::size_t row = 0; row < run.data.rows; ++row) {
    const auto i = static_cast<Index>(row);
    if (static_cast<int>(ordinals[row]) != ordinal || run.data.is_excluded(row) ||
        is_missing(measured->values[row]) || !columns->row(i).allFinite())
      continue;
    seen.of_datum.push_back(i);
    seen.q += measured->values[row];
  }
  if (seen.of_datum.empty()) return std::nullopt;
  seen.q /= static_cast<double>(seen.of_datum.size());
  seen.rows = run.data;
  return seen;
}

// Seen minus the model, the poses moved.
double left_at(const Seen& seen, const std::vector<std::string>& axes, const Eigen::VectorXd& by) {
  Dataset moved = seen.rows;
  for (std::size_t a = 0; a < axes.size(); ++a)
    for (auto& column : moved.columns)
      if (column.channel.name() == axes[a])
        for (double& value : column.values) value += by[static_cast<Index>(a)];
  const auto columns = calibration::raw_columns(moved, seen.terms);
  if (!columns) return kMissing;
  return seen.q - (*columns * seen.coefficients)(seen.of_datum).mean();
}

}  // namespace

Result<RunToCheck> in_model_units(const calibration::Model& model, RunToCheck run) {
  DRIFTWISE_TRY(run.data, calibration::in_model_units(model, std::move(run.data)));
  for (auto& zero : run.zeros) {
    DRIFTWISE_TRY(zero, calibration::in_model_units(model, std::move(zero)));
  }
  for (auto& reading : run.before) {
    DRIFTWISE_TRY(reading.values, calibration::in_model_units(model, std::move(reading.values)));
  }
  return run;
}

RunToCheck in_model_datum(const calibration::Model& model, RunToCheck run) {
  std::vector<std::string> axes;
  std::vector<double> ranges;
  for (const auto& range : model.domain)
    if (is_pose_symbol(range.channel.symbol) && is_length(range.channel.unit)) {
      axes.push_back(range.channel.name());
      ranges.push_back(range.max - range.min);
    }
  if (axes.size() != model.outputs.size()) return run;
  const auto ordinals = calibration::datum_ordinals(run.data);
  const int datums = ordinals.empty() ? 0 : static_cast<int>(*std::ranges::max_element(ordinals));
  std::vector<std::vector<ChannelValue>> poses(static_cast<std::size_t>(datums));
  for (int ordinal = 1; ordinal <= datums; ++ordinal) {
    std::vector<Seen> all;
    for (const auto& output : model.outputs)
      if (auto seen = seen_in(output, run, ordinals, ordinal)) all.push_back(std::move(*seen));
    if (all.size() != model.outputs.size()) continue;
    const Eigen::VectorXd found =
        calibration::pose_of_zero(ranges, [&](const Eigen::VectorXd& shift) {
          Eigen::VectorXd left(shift.size());
          for (Index o = 0; o < left.size(); ++o)
            left[o] = left_at(all[static_cast<std::size_t>(o)], axes, shift);
          return left;
        });
    for (std::size_t a = 0; a < axes.size(); ++a)
      poses[static_cast<std::size_t>(ordinal - 1)].push_back(
          {axes[a], found[static_cast<Index>(a)]});
  }
  for (std::size_t row = 0; row < run.data.rows; ++row)
    for (const auto& [channel, by] : poses[static_cast<std::size_t>(ordinals[row]) - 1])
      for (auto& column : run.data.columns)
        if (column.channel.name() == channel) column.values[row] += by;
  run.zero_poses = std::move(poses);
  return run;
}

Result<RunErrors> run_errors(const calibration::OutputModel& output, std::int64_t calibration_rows,
                             const RunToCheck& run) {
  const Dataset& data = run.data;
  const DatasetColumn* measured = data.find(output.channel.symbol);
  if (!measured)
    return fail(ErrorCode::invalid_argument, reasons::kUnknownChannel,
                "the run has no channel " + output.channel.name());
  const std::vector<Index> carried = carried_terms(output);
  std::vector<effects::Term> terms;
  for (const Index k : carried) terms.push_back(output.terms[static_cast<std::size_t>(k)]);
  DRIFTWISE_TRY(const auto columns, calibration::raw_columns(data, terms));
  const Eigen::VectorXd coefficients = output.coefficients(carried);
  // Standard errors of a fit to correlated rows are too small by the root of rows per effective
  // row.
  const double inflation =
      output.accuracy.effective_rows > 0
          ? std::max(1.0, static_cast<double>(calibration_rows) / output.accuracy.effective_rows)
          : 1.0;
  const Eigen::MatrixXd covariance = output.covariance(carried, carried) * inflation;
  const double factor = summary_unit(output.channel.unit).factor;

  RunErrors errors;
  errors.values.assign(data.rows, kMissing);
  std::map<int, std::vector<Index>> rows_of_datum;
  const auto ordinals = calibration::datum_ordinals(data);
  for (std::size_t row = 0; row < data.rows; ++row) {
    const auto i = static_cast<Index>(row);
    if (data.is_excluded(row) || is_missing(measured->values[row]) || !columns.row(i).allFinite())
      continue;
    rows_of_datum[static_cast<int>(ordinals[row])].push_back(i);
  }
  Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(static_cast<Index>(terms.size()));
  for (const auto& [ordinal, rows] : rows_of_datum) {
    std::optional<Anchor> anchor;
    if (static_cast<std::size_t>(ordinal) <= run.zeros.size())
      anchor = anchor_of(output, terms, data, run.zeros[static_cast<std::size_t>(ordinal - 1)],
                         poses_of(run, ordinal));
    if (!anchor) {
      errors.anchored = false;
      anchor = middle_of(columns, measured->values, rows);
    }
    for (const Index row : rows) {
      const Eigen::RowVectorXd away = columns.row(row) - anchor->columns;
      const double q = measured->values[static_cast<std::size_t>(row)] - anchor->q;
      errors.values[static_cast<std::size_t>(row)] = (q - away.dot(coefficients)) * factor;
      errors.model_variance += (away * covariance).dot(away) * factor * factor;
      sum += away;
      ++errors.rows;
    }
  }
  if (errors.rows == 0) return errors;
  const auto n = static_cast<double>(errors.rows);
  errors.model_variance /= n;
  errors.model_mean_variance = (sum * covariance).dot(sum) * factor * factor / (n * n);
  return errors;
}

}  // namespace driftwise::diagnosis
