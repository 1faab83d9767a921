#include "server/diagnosis/ground.h"

#include <algorithm>
#include <cmath>

namespace driftwise::diagnosis {
namespace {

constexpr double kAlreadyThere = 1e-4;  // of a column's whitened length

}  // namespace

Eigen::MatrixXd beyond(const WhitenedSpace& space, const Eigen::MatrixXd& columns) {
  // Lengths about the mean: a temperature of 20 degC is no longer than its changes are.
  Eigen::MatrixXd left = columns.rowwise() - columns.colwise().mean();
  space.whiten(left);
  const Eigen::RowVectorXd lengths = left.colwise().norm();
  space.project(left);
  Eigen::Index count = 0;
  for (Eigen::Index j = 0; j < left.cols(); ++j) {
    Eigen::VectorXd rest = left.col(j);
    for (int pass = 0; pass < 2; ++pass)  // twice is enough
      rest -= left.leftCols(count) * (left.leftCols(count).transpose() * rest).eval();
    const double length = rest.norm();
    if (!(length > kAlreadyThere * lengths[j]) || !std::isfinite(length)) continue;
    left.col(count++) = rest / length;
  }
  return left.leftCols(count);
}

Ground::Ground(const Timeline& timeline, const std::vector<NoiseShape>& shapes,
               const Eigen::MatrixXd& base, const Eigen::MatrixXd& series,
               const std::function<bool()>& tick)
    : series_(series), criterion_(static_cast<Eigen::Index>(shapes.size()), series.cols()) {
  const Eigen::MatrixXd independent = independent_columns(base);
  spaces_.reserve(shapes.size());
  for (const auto& shape : shapes) {
    if (!spaces_.empty() && tick && !tick()) break;
    spaces_.emplace_back(timeline, shape, independent);
    left_.push_back(spaces_.back().left_over(series_));
    const auto row = static_cast<Eigen::Index>(left_.size()) - 1;
    for (Eigen::Index o = 0; o < series.cols(); ++o)
      criterion_(row, o) = spaces_.back().criterion(left_.back().col(o).squaredNorm());
  }
  criterion_.conservativeResize(static_cast<Eigen::Index>(spaces_.size()), Eigen::NoChange);
  for (Eigen::Index o = 0; o < series.cols(); ++o) {
    Eigen::Index at = 0;
    criterion_.col(o).minCoeff(&at);
    best_.push_back(static_cast<std::size_t>(at));
  }
}

double Ground::white_sd(Eigen::Index output) const {
  const auto at = best_shape(output);
  return std::sqrt(left_[at].col(output).squaredNorm() / static_cast<double>(spaces_[at].dof()));
}

double Ground::worse_by(std::size_t shape, Eigen::Index output) const {
  return criterion_(static_cast<Eigen::Index>(shape), output) -
         criterion_(static_cast<Eigen::Index>(best_shape(output)), output);
}

Eigen::MatrixXd Ground::correlation() const {
  Eigen::MatrixXd left(series_.rows(), series_.cols());
  for (Eigen::Index o = 0; o < series_.cols(); ++o)
    left.col(o) = left_[best_shape(o)].col(o).normalized();
  Eigen::MatrixXd result = left.transpose() * left;
  result.diagonal().setOnes();
  return result;
}

Gain Ground::gain(const Eigen::MatrixXd& columns, const std::vector<char>& on) const {
  Gain result;
  const auto count = static_cast<std::size_t>(outputs());
  result.of_output.assign(count, 0);
  result.shape = best_;
  result.contribution.resize(count);
  Eigen::VectorXd lowest = Eigen::VectorXd::Constant(outputs(), INFINITY);
  std::vector<int> used(count, 0);
  for (std::size_t s = 0; s < spaces_.size(); ++s) {
    const Eigen::MatrixXd basis = beyond(spaces_[s], columns);
    for (Eigen::Index o = 0; o < outputs(); ++o) {
      const auto at = static_cast<std::size_t>(o);
      if (on[at] == 0) continue;
      const Eigen::VectorXd along = basis.transpose() * left_[s].col(o);
      const double rss = left_[s].col(o).squaredNorm();
      const double criterion =
          spaces_[s].criterion(std::max(rss - along.squaredNorm(), 1e-12 * rss));
      if (!(criterion < lowest[o])) continue;
      lowest[o] = criterion;
      result.shape[at] = s;
      result.contribution[at] = basis * along;
      used[at] = static_cast<int>(basis.cols());
    }
  }
  for (Eigen::Index o = 0; o < outputs(); ++o) {
    const auto at = static_cast<std::size_t>(o);
    if (on[at] == 0) continue;
    result.of_output[at] = criterion_(static_cast<Eigen::Index>(best_[at]), o) - lowest[o];
    result.gain += result.of_output[at];
    result.dof += used[at];
  }
  return result;
}

}  // namespace driftwise::diagnosis
