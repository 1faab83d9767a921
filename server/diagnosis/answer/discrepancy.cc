#include "server/diagnosis/answer/discrepancy.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "server/calibration/datum_zeros.h"
#include "server/calibration/design/predict.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/core/units.h"

namespace driftwise::diagnosis {
namespace {

void summarise(OutputDiscrepancy& out) {
  double sum = 0, count = 0;
  for (const double v : out.values)
    if (std::isfinite(v)) sum += v, count += 1;
  out.mean = sum / count;
  double square = 0, neighbours = 0;
  for (std::size_t i = 0; i < out.values.size(); ++i) {
    if (!std::isfinite(out.values[i])) continue;
    square += (out.values[i] - out.mean) * (out.values[i] - out.mean);
    if (i > 0 && std::isfinite(out.values[i - 1]))
      neighbours += (out.values[i] - out.mean) * (out.values[i - 1] - out.mean);
  }
  out.u90 = kSigmaToU90 * std::sqrt(square / (count - 1));
  out.lag1_autocorrelation = square > 0 ? neighbours / square : 0;
}

}  // namespace

double marginal_share(const std::vector<double>& variable, const std::vector<double>& y) {
  std::vector<std::size_t> rows;
  double low = INFINITY, high = -INFINITY;
  for (std::size_t i = 0; i < y.size(); ++i) {
    if (!std::isfinite(y[i]) || !std::isfinite(variable[i])) continue;
    rows.push_back(i);
    low = std::min(low, variable[i]);
    high = std::max(high, variable[i]);
  }
  if (rows.size() < 4 || !(high > low)) return 0;
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(rows.size()), 3);
  Eigen::VectorXd values(columns.rows());
  for (Eigen::Index i = 0; i < columns.rows(); ++i) {
    const std::size_t row = rows[static_cast<std::size_t>(i)];
    const double u = (2 * variable[row] - low - high) /
                     (high - low);  // scaled: v^2 beside v stays well conditioned
    columns.row(i) << 1, u, u * u;
    values[i] = y[row];
  }
  const double total = (values.array() - values.mean()).square().sum();
  if (total <= 0) return 0;
  const Eigen::VectorXd rest = values - columns * columns.colPivHouseholderQr().solve(values);
  return std::clamp(1 - rest.squaredNorm() / total, 0.0, 1.0);
}

Result<std::vector<OutputDiscrepancy>> discrepancy(const calibration::Model& model,
                                                   const Dataset& dataset) {
  std::vector<OutputDiscrepancy> outputs;
  const Dataset moved = calibration::in_first_datum(dataset, model.datum_zeros);
  for (const auto& output : model.outputs) {
    const DatasetColumn* measured = dataset.find(output.channel.symbol);
    if (!measured)
      return fail(ErrorCode::invalid_argument, reasons::kUnknownChannel,
                  "the dataset has no column " + output.channel.name());
    DRIFTWISE_TRY(const auto prediction, calibration::predict(moved, output));
    const Eigen::VectorXd& predicted = prediction;
    OutputDiscrepancy out;
    out.channel = output.channel;
    const SummaryUnit unit = summary_unit(output.channel.unit);
    out.unit = unit.unit;
    std::size_t complete = 0;
    for (std::size_t i = 0; i < dataset.rows; ++i) {
      out.values.push_back((measured->values[i] - predicted[static_cast<Eigen::Index>(i)]) *
                           unit.factor);
      complete += std::isfinite(out.values.back()) ? 1 : 0;
    }
    if (complete < 4)
      return fail(ErrorCode::invalid_argument, reasons::kTooFewRows,
                  "only " + std::to_string(complete) + " rows have every channel that " +
                      output.channel.name() + " needs: at least 4 are wanted");
    summarise(out);
    for (const auto& column : dataset.columns)
      if (column.channel.symbol != output.channel.symbol)
        out.explained_by.push_back(
            {column.channel.symbol, marginal_share(column.values, out.values)});
    if (!dataset.time_s.empty())
      out.explained_by.push_back({"time", marginal_share(dataset.time_s, out.values)});
    std::ranges::stable_sort(out.explained_by, std::ranges::greater{}, &Share::share);
    outputs.push_back(std::move(out));
  }
  return outputs;
}

}  // namespace driftwise::diagnosis
