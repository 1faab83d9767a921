#include "server/diagnosis/robot/left_out.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "server/diagnosis/rows/place_groups.h"

namespace driftwise::diagnosis {
namespace {

using Eigen::Index;

constexpr std::size_t kTimeFolds = 5, kPlaceFolds = 6, kDriverParts = 6;
constexpr double kGap = 0.04;  // of the rows, on either side of a block of time
constexpr double kNothing = 1e-9;

// 2 ln of the predictive density of rows left out: columns with a prior `precision`, fitted to the
// others. gram, along: of all rows; x, y: of the rows that take no part; of which the first
// `judged` are predicted and the rest only left out.
double predictive(const Eigen::MatrixXd& gram, const Eigen::VectorXd& along,
                  const Eigen::VectorXd& precision, const Eigen::MatrixXd& x,
                  const Eigen::VectorXd& y, Index judged) {
  Eigen::MatrixXd a = gram - x.transpose() * x;
  a.diagonal() += precision;
  a.diagonal().array() += kNothing;
  const Eigen::LLT<Eigen::MatrixXd> fitted(a);
  const Eigen::VectorXd b = fitted.solve(along - x.transpose() * y);
  const auto rows = x.topRows(judged);
  const Eigen::VectorXd e = y.head(judged) - rows * b;
  const Eigen::LLT<Eigen::MatrixXd> with(a + rows.transpose() * rows);
  double log_ratio = 0;
  for (Index k = 0; k < a.cols(); ++k)
    log_ratio += 2 * std::log(with.matrixL()(k, k) / fitted.matrixL()(k, k));
  const Eigen::VectorXd xe = rows.transpose() * e;
  return -(e.squaredNorm() - xe.dot(with.solve(xe))) - log_ratio;
}

}  // namespace

Eigen::MatrixXd scaled_rows(const Eigen::MatrixXd& inputs, const std::vector<std::size_t>& rows) {
  Eigen::MatrixXd places = inputs(Eigen::all, rows).transpose();
  const Eigen::RowVectorXd low = places.colwise().minCoeff();
  const Eigen::RowVectorXd range = (places.colwise().maxCoeff() - low).cwiseMax(kNothing);
  return (places.rowwise() - low) * range.cwiseInverse().asDiagonal();
}

Folds folds_of_time(std::size_t rows) {
  Folds folds(kTimeFolds);
  for (std::size_t i = 0; i < rows; ++i) folds[i * kTimeFolds / rows].push_back(i);
  return folds;
}

Folds folds_of_places(const Eigen::MatrixXd& places) {
  std::vector<std::vector<double>> all;
  for (Index i = 0; i < places.rows(); ++i) {
    const Eigen::VectorXd row = places.row(i);
    all.emplace_back(row.begin(), row.end());
  }
  return neighbouring_groups(all, kPlaceFolds);
}

Folds folds_of_driver(const Eigen::VectorXd& driver) {
  const auto rows = static_cast<std::size_t>(driver.size());
  std::vector<std::size_t> order(rows);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return driver[static_cast<Index>(i)]; });
  Folds folds(kDriverParts);
  for (std::size_t i = 0; i < rows; ++i) folds[i * kDriverParts / rows].push_back(order[i]);
  return folds;
}

LeftOut::LeftOut(const Eigen::MatrixXd& base, const Eigen::MatrixXd& own,
                 const Eigen::VectorXd& precision, Index in_question, Eigen::VectorXd y, Index rows)
    : all_(base.rows(), base.cols() + own.cols()),
      precision_(Eigen::VectorXd::Zero(base.cols() + own.cols())),
      y_(std::move(y)),
      own_(in_question),
      rows_(rows),
      outputs_(y_.size() / rows) {
  all_ << base, own;
  precision_.tail(own.cols()) = precision;
  gram_ = all_.transpose() * all_;
  along_ = all_.transpose() * y_;
}

std::vector<Index> LeftOut::stacked(const std::vector<std::size_t>& rows) const {
  std::vector<Index> all;
  for (Index o = 0; o < outputs_; ++o)
    for (const std::size_t row : rows) all.push_back(o * rows_ + static_cast<Index>(row));
  return all;
}

double LeftOut::growth_over_time(const Folds& folds) const {
  return growth(folds, static_cast<std::size_t>(kGap * static_cast<double>(rows_)));
}

double LeftOut::growth(const Folds& folds, std::size_t idle_rows) const {
  double gain = 0;
  for (const auto& fold : folds) {
    auto out = stacked(fold);
    const auto judged = static_cast<Index>(out.size());
    std::vector<std::size_t> idle;  // the fold is a block of rows
    for (std::size_t i = 1; i <= idle_rows; ++i) {
      if (fold.front() >= i) idle.push_back(fold.front() - i);
      if (fold.back() + i < static_cast<std::size_t>(rows_)) idle.push_back(fold.back() + i);
    }
    const auto beside = stacked(idle);
    out.insert(out.end(), beside.begin(), beside.end());
    const Eigen::MatrixXd x = all_(out, Eigen::all);
    const Eigen::VectorXd y = y_(out);
    const Index less = all_.cols() - own_;
    gain += predictive(gram_, along_, precision_, x, y, judged) -
            predictive(gram_.topLeftCorner(less, less), along_.head(less), precision_.head(less),
                       x.leftCols(less), y, judged);
  }
  return gain;
}

double LeftOut::t_without(const Folds& folds) const {
  const auto amplitude = [&](const Eigen::MatrixXd& x, const Eigen::VectorXd& y) {
    Eigen::MatrixXd a = gram_ - x.transpose() * x;
    a.diagonal() += precision_;
    a.diagonal().array() += kNothing;
    return Eigen::VectorXd(a.llt().solve(along_ - x.transpose() * y).tail(own_));
  };
  const Eigen::VectorXd whole =
      amplitude(Eigen::MatrixXd::Zero(0, all_.cols()), Eigen::VectorXd::Zero(0));
  Eigen::VectorXd without(static_cast<Index>(folds.size()));
  for (std::size_t f = 0; f < folds.size(); ++f) {
    const auto out = stacked(folds[f]);
    without[static_cast<Index>(f)] =
        amplitude(all_(out, Eigen::all), y_(out)).dot(whole) / std::max(whole.norm(), 1e-300);
  }
  const auto n = static_cast<double>(folds.size());
  const double error = std::sqrt((n - 1) / n * (without.array() - without.mean()).square().sum());
  return error > 0 ? whole.norm() / error : 0;
}

}  // namespace driftwise::diagnosis
