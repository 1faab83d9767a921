#include "server/calibration/linear/orthogonal_set.h"

#include <Eigen/Jacobi>
#include <algorithm>
#include <cmath>
#include <limits>

namespace driftwise::calibration {
namespace {

constexpr double kCollinear = 1e-7;

double t_of(double coefficient, double standard_error) {
  if (standard_error > 0) return coefficient / standard_error;
  return coefficient == 0 ? 0 : std::copysign(std::numeric_limits<double>::infinity(), coefficient);
}

}  // namespace

OrthogonalSet::OrthogonalSet(const Eigen::MatrixXd& columns,
                             const Eigen::Ref<const Eigen::VectorXd>& y, double beyond,
                             std::int64_t rows, const Eigen::VectorXd& own_norms)
    : columns_(columns),
      y_(y),
      beyond_(beyond),
      total_(y.squaredNorm() + beyond),
      rows_(rows),
      own_norms_(own_norms),
      norms_(columns.colwise().norm()) {
  reset();
}

void OrthogonalSet::reset() {
  order_.clear();
  work_.resize(columns_.rows(), columns_.cols() + 1);
  work_.leftCols(columns_.cols()) = columns_;
  work_.rightCols(1) = y_;
  update_rss();
}

void OrthogonalSet::update_rss() {
  rss_ = work_.rightCols(1).bottomRows(work_.rows() - depth()).squaredNorm() + beyond_;
}

void OrthogonalSet::enter(int column) {
  const Eigen::Index k = depth(), tail = work_.rows() - k;
  Eigen::VectorXd v = work_.col(column).tail(tail);
  const double norm = v.norm();
  const double alpha = v[0] > 0 ? -norm : norm;
  v[0] -= alpha;
  const double scale = v.squaredNorm();
  if (scale > 0) {
    for (Eigen::Index j = 0; j < work_.cols(); ++j) {
      if (j < columns_.cols() && has(static_cast<int>(j))) continue;
      auto rest = work_.col(j).tail(tail);
      const double step = 2 * v.dot(rest) / scale;
      rest -= step * v;
    }
  }
  work_.col(column).tail(tail).setZero();
  work_(k, column) = alpha;
  order_.push_back(column);
  update_rss();
}

void OrthogonalSet::remove(int column) {
  const auto at = std::ranges::find(order_, column);
  if (at == order_.end()) return;
  auto row = static_cast<Eigen::Index>(at - order_.begin());
  order_.erase(at);
  // The later columns now reach one row below the diagonal each.
  for (; row < depth(); ++row) {
    const int next = order_[static_cast<std::size_t>(row)];
    Eigen::JacobiRotation<double> rotation;
    rotation.makeGivens(work_(row, next), work_(row + 1, next));
    work_.applyOnTheLeft(row, row + 1, rotation.adjoint());
    work_(row + 1, next) = 0;
  }
  update_rss();
}

bool OrthogonalSet::has(int column) const {
  return std::ranges::find(order_, column) != order_.end();
}

double OrthogonalSet::rmse() const { return dof() > 0 ? std::sqrt(rss_ / dof()) : 0; }

double OrthogonalSet::left_over(int column) const {
  return work_.col(column).tail(work_.rows() - depth()).norm();
}

bool OrthogonalSet::collinear(int column) const {
  const double left = left_over(column);
  return !(left > kCollinear * std::min(norms_[column], own_norms_[column]));
}

TermStatistics OrthogonalSet::outside(int column) const {
  TermStatistics result;
  const int dof_after = dof() - 1;
  if (dof_after < 1 || collinear(column)) return result;
  const Eigen::Index tail = work_.rows() - depth();
  const auto a = work_.col(column).tail(tail);
  const auto y = work_.rightCols(1).bottomRows(tail).col(0);
  const double aa = a.squaredNorm();
  result.estimable = true;
  result.coefficient = a.dot(y) / aa;
  // The remainder itself, not a difference of sums of squares: at nm noise over mm signals the
  // difference has no digits.
  const double rss_after = (y - result.coefficient * a).squaredNorm() + beyond_;
  result.standard_error = std::sqrt(rss_after / dof_after / aa);
  result.t = t_of(result.coefficient, result.standard_error);
  return result;
}

std::vector<TermStatistics> OrthogonalSet::inside() const {
  const Eigen::Index k = depth();
  Eigen::MatrixXd upper(k, k);
  for (Eigen::Index c = 0; c < k; ++c)
    upper.col(c) = work_.col(order_[static_cast<std::size_t>(c)]).head(k);
  const auto triangle = upper.triangularView<Eigen::Upper>();
  const Eigen::MatrixXd inverse = triangle.solve(Eigen::MatrixXd::Identity(k, k));
  const Eigen::VectorXd coefficients = triangle.solve(work_.rightCols(1).topRows(k));
  std::vector<TermStatistics> result(order_.size());
  for (Eigen::Index c = 0; c < k; ++c) {
    auto& one = result[static_cast<std::size_t>(c)];
    one.estimable = dof() > 0;
    one.coefficient = coefficients[c];
    one.standard_error = rmse() * inverse.row(c).norm();
    one.t = t_of(one.coefficient, one.standard_error);
  }
  return result;
}

Eigen::VectorXd OrthogonalSet::reproduced_by_set(int column) const {
  const Eigen::Index k = depth();
  Eigen::MatrixXd upper(k, k);
  for (Eigen::Index c = 0; c < k; ++c)
    upper.col(c) = work_.col(order_[static_cast<std::size_t>(c)]).head(k);
  return upper.triangularView<Eigen::Upper>().solve(work_.col(column).head(k));
}

}  // namespace driftwise::calibration
