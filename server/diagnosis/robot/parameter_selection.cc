#include "server/diagnosis/robot/parameter_selection.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "server/calibration/linear/tail.h"

namespace driftwise::diagnosis {
namespace {

using Eigen::Index;

constexpr double kRivalWithin_2lnl = 6;

Eigen::MatrixXd picked(const Eigen::MatrixXd& r, const std::vector<Index>& columns) {
  Eigen::MatrixXd some(r.rows(), static_cast<Index>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i)
    some.col(static_cast<Index>(i)) = r.col(columns[i]);
  return some;
}

}  // namespace

ParameterSelection::ParameterSelection(const std::vector<Whitened>& ways, std::vector<Role> roles)
    : scale_(ways.front().columns.colwise().norm().cwiseMax(1e-300)),
      rows_(static_cast<double>(ways.front().y.size())),
      roles_(std::move(roles)),
      forbidden_(roles_.size(), 0) {
  for (const auto& way : ways) {
    const Eigen::RowVectorXd lengths = way.columns.colwise().norm().cwiseMax(1e-300);
    Eigen::MatrixXd all(way.columns.rows(), way.columns.cols() + 1);
    all << way.columns * lengths.cwiseInverse().asDiagonal(), way.y;
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(all);
    r_.emplace_back(qr.matrixQR().topRows(all.cols()).triangularView<Eigen::Upper>());
  }
}

bool ParameterSelection::is_in(std::size_t column) const {
  return roles_[column] == Role::always_in || std::ranges::find(chosen_, column) != chosen_.end();
}

std::vector<Index> ParameterSelection::columns_in(std::size_t without, std::size_t with) const {
  std::vector<Index> in;
  for (std::size_t i = 0; i < roles_.size(); ++i)
    if (i != without && (is_in(i) || i == with)) in.push_back(static_cast<Index>(i));
  return in;
}

double ParameterSelection::rss(const std::vector<Index>& columns, std::size_t way) const {
  const Eigen::MatrixXd& r = r_[way];
  const Eigen::VectorXd y = r.col(r.cols() - 1);
  if (columns.empty()) return y.squaredNorm();
  const Eigen::MatrixXd x = picked(r, columns);
  return (y - x * x.colPivHouseholderQr().solve(y)).squaredNorm();
}

double ParameterSelection::two_sided_p(const std::vector<Index>& without,
                                       const std::vector<Index>& with) const {
  const double dof = rows_ - static_cast<double>(with.size());
  if (!(dof > 0)) return 1;
  const auto offered = static_cast<double>(std::ranges::count(roles_, Role::offered));
  double largest = 0;
  for (std::size_t way = 0; way < r_.size(); ++way) {
    const double left = rss(with, way);
    if (!(left > 0)) return 1;
    const double t = std::sqrt(std::max(0.0, rss(without, way) - left) / (left / dof));
    largest = std::max(largest, offered * calibration::t_two_sided_p(t, dof));
  }
  return std::min(1.0, largest);
}

void ParameterSelection::forbid(std::size_t column) {
  forbidden_[column] = 1;
  std::erase(chosen_, column);
}

void ParameterSelection::select(double alpha) {
  // Each entry lowers the residual sum, so the loop ends; twice the columns is beyond what it
  // needs.
  for (std::size_t turn = 0; turn < 2 * roles_.size(); ++turn) {
    double lowest = rss(columns_in());
    std::size_t best = kNone;
    for (std::size_t i = 0; i < roles_.size(); ++i) {
      if (roles_[i] != Role::offered || is_in(i) || forbidden_[i] != 0) continue;
      const double with = rss(columns_in(kNone, i));
      if (with < lowest) lowest = with, best = i;
    }
    if (best == kNone || two_sided_p(columns_in(), columns_in(kNone, best)) > alpha) return;
    chosen_.push_back(best);
    std::erase_if(chosen_, [&](std::size_t one) { return adjusted_p(one) > alpha; });
    if (std::ranges::find(chosen_, best) == chosen_.end()) return;
  }
}

double ParameterSelection::adjusted_p(std::size_t column) const {
  return two_sided_p(columns_in(column), columns_in());
}

double ParameterSelection::gain_2lnl(std::size_t column) const {
  return rows_ * std::log(rss(columns_in(column)) / rss(columns_in()));
}

std::vector<std::size_t> ParameterSelection::rivals(std::size_t column) const {
  std::vector<std::size_t> close;
  const double now = rss(columns_in());
  for (std::size_t i = 0; i < roles_.size(); ++i) {
    if (is_in(i)) continue;
    if (rows_ * std::log(rss(columns_in(column, i)) / now) < kRivalWithin_2lnl) close.push_back(i);
  }
  return close;
}

Eigen::VectorXd ParameterSelection::fitted(const std::vector<Index>& in) const {
  const Eigen::MatrixXd& r = r_.front();
  const Eigen::VectorXd b = picked(r, in).colPivHouseholderQr().solve(r.col(r.cols() - 1));
  Eigen::VectorXd all = Eigen::VectorXd::Zero(scale_.size());
  for (std::size_t i = 0; i < in.size(); ++i) all[in[i]] = b[static_cast<Index>(i)] / scale_[in[i]];
  return all;
}

Eigen::VectorXd ParameterSelection::coefficients(std::size_t without) const {
  return fitted(columns_in(without));
}

Eigen::VectorXd ParameterSelection::coefficients_of_none() const {
  std::vector<Index> always;
  for (std::size_t i = 0; i < roles_.size(); ++i)
    if (roles_[i] == Role::always_in) always.push_back(static_cast<Index>(i));
  return fitted(always);
}

Eigen::VectorXd ParameterSelection::standard_errors() const {
  const auto in = columns_in();
  const Eigen::MatrixXd x = picked(r_.front(), in);
  const double variance = rss(in) / std::max(1.0, rows_ - static_cast<double>(in.size()));
  const Eigen::MatrixXd covariance =
      (x.transpose() * x).ldlt().solve(Eigen::MatrixXd::Identity(x.cols(), x.cols())) * variance;
  Eigen::VectorXd all = Eigen::VectorXd::Zero(scale_.size());
  for (std::size_t i = 0; i < in.size(); ++i)
    all[in[i]] =
        std::sqrt(covariance(static_cast<Index>(i), static_cast<Index>(i))) / scale_[in[i]];
  return all;
}

}  // namespace driftwise::diagnosis
