#include "server/diagnosis/rows/weighted_fit.h"

#include <Eigen/QR>
#include <cmath>

namespace driftwise::diagnosis {
namespace {

constexpr double kDependentPivot = 1e-9;  // of the largest pivot of columns of length 1

}  // namespace

WeightedFit::WeightedFit(const Problem& problem, const SoftBase& base, const Eigen::MatrixXd& added,
                         std::size_t output, NoiseShape noise, const AddedPrior& prior)
    : base_(base.columns.cols()) {
  const Eigen::Index rows = problem.timeline.rows(), p = base_ + added.cols();
  Eigen::VectorXd all_precision = Eigen::VectorXd::Zero(p);
  if (base.precision.size() > 0) all_precision.head(base_) = base.precision;
  for (Eigen::Index k = 0; k < prior.sd.size(); ++k)
    if (prior.sd[k] > 0) all_precision[base_ + k] = whitened_precision(prior.noise, prior.sd[k]);
  const Eigen::Index priors = (all_precision.array() > 0).count(), n = rows + priors;
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(n, p + 1);
  Eigen::MatrixXd measured(rows, p + 1);
  measured.leftCols(base_) = base.columns;
  if (added.cols() > 0) measured.middleCols(base_, added.cols()) = added;
  measured.col(p) = problem.learned(problem.outputs[output].measured);
  const Whitener whitener(problem.timeline, noise, static_cast<Eigen::Index>(output));
  whitener.apply(measured);
  all.topRows(rows) = measured;
  for (Eigen::Index k = 0, at = rows; k < p; ++k)
    if (all_precision[k] > 0) all(at++, k) = std::sqrt(all_precision[k]);
  const Eigen::VectorXd scale = all.leftCols(p).colwise().norm().cwiseMax(1e-300);
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(all.leftCols(p) *
                                                 scale.cwiseInverse().asDiagonal());
  qr.setThreshold(kDependentPivot);
  const Eigen::VectorXd scaled = qr.solve(all.col(p));
  coefficients_ = scaled.cwiseQuotient(scale);
  const Eigen::VectorXd left = all.col(p) - all.leftCols(p) * coefficients_;
  const Eigen::Index rank = qr.rank();
  const double sigma =
      std::sqrt(left.squaredNorm() / static_cast<double>(std::max<Eigen::Index>(n - rank, 1)));
  const Eigen::MatrixXd inverse = qr.matrixR()
                                      .topLeftCorner(rank, rank)
                                      .triangularView<Eigen::Upper>()
                                      .solve(Eigen::MatrixXd::Identity(rank, rank));
  errors_ = Eigen::VectorXd::Constant(p, NAN);
  root_ = Eigen::MatrixXd::Constant(p, rank, NAN);
  for (Eigen::Index k = 0; k < rank; ++k) {
    const Eigen::Index column = qr.colsPermutation().indices()[k];
    root_.row(column) = sigma / scale[column] * inverse.row(k);
    errors_[column] = root_.row(column).norm();
  }
}

double WeightedFit::added_spread(const Eigen::MatrixXd& columns) const {
  const Eigen::MatrixXd reached = columns * root_.middleRows(base_, columns.cols());
  return std::sqrt(reached.squaredNorm() /
                   static_cast<double>(std::max<Eigen::Index>(columns.rows(), 1)));
}

}  // namespace driftwise::diagnosis
