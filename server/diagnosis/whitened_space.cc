#include "server/diagnosis/whitened_space.h"

#include <Eigen/QR>
#include <cmath>

namespace driftwise::diagnosis {
namespace {

constexpr double kDependent = 1e-7;  // of a column's length: R's rank tolerance

}  // namespace

WhitenedSpace::WhitenedSpace(const Timeline& timeline, NoiseShape shape,
                             const Eigen::MatrixXd& base)
    : shape_(shape), whitener_(timeline, shape) {
  Eigen::MatrixXd white = base;
  whitener_.apply(white);
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(white);
  basis_ = qr.householderQ() * Eigen::MatrixXd::Identity(base.rows(), base.cols());
  log_determinants_ = whitener_.log_determinant();
  for (Eigen::Index j = 0; j < base.cols(); ++j)
    log_determinants_ += 2 * std::log(std::abs(qr.matrixQR()(j, j)));
}

void WhitenedSpace::project(Eigen::Ref<Eigen::MatrixXd> white) const {
  white.noalias() -= basis_ * (basis_.transpose() * white).eval();
}

Eigen::MatrixXd WhitenedSpace::left_over(Eigen::MatrixXd columns) const {
  whiten(columns);
  project(columns);
  return columns;
}

double WhitenedSpace::criterion(double rss) const {
  return static_cast<double>(dof()) * std::log(rss) + log_determinants_;
}

Eigen::MatrixXd independent_columns(const Eigen::MatrixXd& columns) {
  Eigen::MatrixXd basis(columns.rows(), columns.cols()), kept(columns.rows(), columns.cols());
  Eigen::Index count = 0;
  for (Eigen::Index j = 0; j < columns.cols(); ++j) {
    const double length = columns.col(j).norm();
    if (!(length > 0)) continue;
    Eigen::VectorXd rest = columns.col(j) / length;
    for (int pass = 0; pass < 2; ++pass)  // twice is enough
      rest -= basis.leftCols(count) * (basis.leftCols(count).transpose() * rest).eval();
    if (rest.norm() < kDependent) continue;
    kept.col(count) = columns.col(j) / length;
    basis.col(count++) = rest.normalized();
  }
  return kept.leftCols(count);
}

}  // namespace driftwise::diagnosis
