#include "server/diagnosis/noise/whitened_space.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <cmath>

#include "server/calibration/linear/tall_kernels.h"

namespace driftwise::diagnosis {
namespace {

namespace tall = calibration::tall;

constexpr double kDependent = 1e-7;  // of a column's length: R's rank tolerance
constexpr double kNothing = 1e-12;   // of what a prior adds to the variance of a row's noise

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

}  // namespace

WhitenedSpace::WhitenedSpace(const Timeline& timeline, NoiseShape shape, const SoftBase& base,
                             Eigen::Index output)
    : shape_(shape), whitener_(timeline, shape, output), free_(base.free_count()) {
  const Eigen::Index soft = base.columns.cols() - free_;
  Eigen::MatrixXd white = base.columns;
  whitener_.apply(white);
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(white.leftCols(free_));
  basis_.resize(white.rows(), free_ + soft);
  basis_.leftCols(free_) = qr.householderQ() * Eigen::MatrixXd::Identity(white.rows(), free_);
  removed_ = Eigen::VectorXd::Ones(free_ + soft);
  log_determinants_ = whitener_.log_determinant();
  for (Eigen::Index j = 0; j < free_; ++j)
    log_determinants_ += 2 * std::log(std::abs(qr.matrixQR()(j, j)));
  if (soft == 0) return;
  Eigen::MatrixXd beyond = white.rightCols(soft);
  for (int pass = 0; pass < 2; ++pass)
    beyond -= basis_.leftCols(free_) * (basis_.leftCols(free_).transpose() * beyond).eval();
  beyond = beyond * base.precision.tail(soft).cwiseSqrt().cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(beyond.transpose() * beyond);
  Eigen::Index count = free_;
  for (Eigen::Index k = 0; k < soft; ++k) {
    const double added = eigen.eigenvalues()[k];
    if (!(added > kNothing)) continue;
    basis_.col(count) = (beyond * eigen.eigenvectors().col(k)) / std::sqrt(added);
    removed_[count++] = 1 - 1 / std::sqrt(1 + added);
    log_determinants_ += std::log1p(added);
  }
  basis_.conservativeResize(Eigen::NoChange, count);
  removed_.conservativeResize(count);
}

void WhitenedSpace::project(Eigen::Ref<Eigen::MatrixXd> white) const {
  if (basis_.cols() == 0 || white.cols() == 0) return;
  // By the kernels of a fit, which use the processor's widest vectors; the last rows, fewer than a
  // vector holds, by themselves.
  const Eigen::Index rest = white.rows() % tall::kLanes, whole = white.rows() - rest;
  const tall::Block columns{white.data(), white.outerStride(), whole, white.cols()};
  // Blocks are not const; the kernels read this one only.
  const tall::Block directions{const_cast<double*>(basis_.data()), basis_.outerStride(), whole,
                               basis_.cols()};
  Eigen::MatrixXd along(basis_.cols(), white.cols());
  tall::products(directions, columns, along.data(), along.rows());
  along.noalias() += basis_.bottomRows(rest).transpose() * white.bottomRows(rest);
  along.array().colwise() *= removed_.array();
  tall::subtract_product(directions, along.data(), along.rows(), columns);
  white.bottomRows(rest).noalias() -= basis_.bottomRows(rest) * along;
}

Eigen::MatrixXd WhitenedSpace::left_over(Eigen::MatrixXd columns) const {
  whiten(columns);
  project(columns);
  return columns;
}

Eigen::MatrixXd WhitenedSpace::gram_beyond(const Eigen::MatrixXd& white) const {
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(white.cols(), white.cols());
  gram.selfadjointView<Eigen::Lower>().rankUpdate(white.transpose());
  // (1 - r)^2 = 1 - r (2 - r) of each direction is left.
  const Eigen::MatrixXd within =
      (removed_.array() * (2 - removed_.array())).sqrt().matrix().asDiagonal() *
      (basis_.transpose() * white);
  gram.selfadjointView<Eigen::Lower>().rankUpdate(within.transpose(), -1);
  gram.triangularView<Eigen::StrictlyUpper>() = gram.transpose();
  return gram;
}

double WhitenedSpace::criterion(double rss) const {
  return static_cast<double>(dof()) * std::log(rss) + log_determinants_;
}

SoftBase independent_base(const SoftBase& base) {
  const Eigen::Index free = base.free_count(), soft = base.columns.cols() - free;
  const Eigen::MatrixXd kept = independent_columns(base.columns.leftCols(free));
  SoftBase result;
  result.columns.resize(base.columns.rows(), kept.cols() + soft);
  result.columns << kept, base.columns.rightCols(soft);
  result.precision = Eigen::VectorXd::Zero(kept.cols() + soft);
  if (soft > 0) result.precision.tail(soft) = base.precision.tail(soft);
  result.hidden = base.hidden;
  return result;
}

Eigen::MatrixXd drawn_hidden(const SoftBase& base, Eigen::Index outputs, std::mt19937_64& random) {
  std::normal_distribution<double> normal(0, 1);
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(base.columns.rows(), outputs);
  const Eigen::Index first = base.free_count();
  for (Eigen::Index o = 0; o < outputs; ++o)
    for (Eigen::Index k = first; k < first + base.hidden; ++k)
      result.col(o) += normal(random) / std::sqrt(base.precision[k]) * base.columns.col(k);
  return result;
}

}  // namespace driftwise::diagnosis
