#include "server/calibration/linear/projection.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>

#include "server/calibration/design/design.h"
#include "server/calibration/design/predict.h"
#include "server/core/try.h"
#include "server/effects/term_order.h"

namespace driftwise::calibration {
namespace {

using Eigen::Index;

bool has_memory(const OutputModel& output) {
  for (const auto& term : output.terms)
    for (const auto& factor : term.factors)
      if (const auto* call = std::get_if<effects::Call>(&factor); call && call->effect != "datum")
        return true;
  return false;
}

}  // namespace

Excerpt::Excerpt(const Dataset& dataset, const std::vector<std::size_t>& rows,
                 const OutputModel& output, std::size_t at_most) {
  const auto datums = datum_ordinals(dataset);
  const bool one_datum =
      std::ranges::all_of(rows, [&](std::size_t row) { return datums[row] == datums[rows[0]]; });
  const bool whole = !one_datum || has_memory(output);
  const std::size_t count = whole ? rows.size() : std::min(rows.size(), at_most);
  if (whole) {
    data_ = dataset;
  } else {
    data_.rows = count;
    for (const auto& column : dataset.columns) data_.columns.push_back({column.channel, {}});
  }
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t place = i * rows.size() / count, row = rows[place];
    place_.push_back(static_cast<Index>(place));
    rows_.push_back(static_cast<Index>(whole ? row : i));
    datum_.push_back(datums[row]);
    if (!dataset.time_s.empty()) time_s_.push_back(dataset.time_s[row]);
    if (whole) continue;
    for (std::size_t c = 0; c < data_.columns.size(); ++c)
      data_.columns[c].values.push_back(dataset.columns[c].values[row]);
  }
}

Result<Eigen::MatrixXd> Excerpt::columns(const std::vector<effects::Term>& terms) const {
  DRIFTWISE_TRY(auto all, raw_columns(data_, terms));
  return Eigen::MatrixXd(all(rows_, Eigen::all));
}

std::vector<const DatasetColumn*> Excerpt::thermometers() const {
  std::vector<const DatasetColumn*> out;
  for (const auto& column : data_.columns)
    if (column.channel.unit == "degC") out.push_back(&column);
  return out;
}

Eigen::VectorXd Excerpt::values(const DatasetColumn& column) const {
  return Eigen::Map<const Eigen::VectorXd>(column.values.data(),
                                           static_cast<Index>(column.values.size()))(rows_);
}

Projection::Projection(Eigen::MatrixXd columns, const std::vector<effects::Term>& terms,
                       const Eigen::VectorXd& weights)
    : root_weights_(weights.size() > 0 ? Eigen::VectorXd(weights.cwiseMax(0).cwiseSqrt())
                                       : Eigen::VectorXd::Ones(columns.rows())) {
  const Index count = columns.cols();
  const auto found = std::ranges::find_if(terms, &effects::Term::is_constant);
  const Index constant = found == terms.end() ? -1 : found - terms.begin();
  Eigen::RowVectorXd means = Eigen::RowVectorXd::Zero(count);
  if (constant >= 0) {
    means = columns.colwise().mean();
    means[constant] = 0;
    columns.rowwise() -= means;
  }
  const Eigen::RowVectorXd scale = columns.colwise().norm().cwiseMax(1e-300);
  columns = root_weights_.asDiagonal() * columns * scale.cwiseInverse().asDiagonal();
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(columns);
  q_ = qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), count);
  back_ = qr.matrixQR().topRows(count).triangularView<Eigen::Upper>().solve(
      Eigen::MatrixXd::Identity(count, count));
  back_ = scale.cwiseInverse().asDiagonal() * back_;
  if (constant >= 0) back_.row(constant) -= means * back_;
}

Eigen::VectorXd Projection::coefficients(const Eigen::VectorXd& y) const {
  return back_ * (q_.transpose() * root_weights_.cwiseProduct(y));
}

Projection Projection::over(const std::vector<Index>& rows) const {
  // Share of a direction's squares that the rows must have, against the direction they have most
  // of: below, it would be drawn from next to nothing.
  constexpr double kDetermined = 1e-3;
  Projection out;
  out.root_weights_ = Eigen::VectorXd(root_weights_(rows));
  out.back_ = back_;
  const Eigen::MatrixXd q = q_(rows, Eigen::all);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(q.transpose() * q);
  const Eigen::VectorXd& shares = solver.eigenvalues();
  const double least = kDetermined * shares.maxCoeff();
  const Eigen::VectorXd inverse =
      shares.unaryExpr([least](double share) { return share > least ? 1 / share : 0.0; });
  out.q_ = q * solver.eigenvectors() * inverse.asDiagonal() * solver.eigenvectors().transpose();
  return out;
}

}  // namespace driftwise::calibration
