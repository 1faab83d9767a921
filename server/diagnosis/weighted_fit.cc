#include "server/diagnosis/weighted_fit.h"

#include <Eigen/QR>
#include <cmath>

namespace driftwise::diagnosis {
namespace {

constexpr double kDependentPivot = 1e-9;  // of the largest pivot of columns of length 1

}  // namespace

WeightedFit::WeightedFit(const Problem& problem, const Eigen::MatrixXd& base,
                         const Eigen::MatrixXd& added, std::size_t output, NoiseShape noise)
    : base_(base.cols()) {
  const Eigen::Index n = problem.timeline.rows(), p = base.cols() + added.cols();
  Eigen::MatrixXd all(n, p + 1);
  all.leftCols(base.cols()) = base;
  if (added.cols() > 0) all.middleCols(base.cols(), added.cols()) = added;
  all.col(p) = problem.learned(problem.outputs[output].measured);
  const Whitener whitener(problem.timeline, noise);
  whitener.apply(all);
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
