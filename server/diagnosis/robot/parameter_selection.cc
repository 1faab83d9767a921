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

ParameterSelection::ParameterSelection(const Eigen::MatrixXd& columns, const Eigen::VectorXd& y,
                                       std::vector<Role> roles)
    : scale_(columns.colwise().norm().cwiseMax(1e-300)),
      rows_(static_cast<double>(y.size())),
      roles_(std::move(roles)) {
  Eigen::MatrixXd all(columns.rows(), columns.cols() + 1);
  all << columns * scale_.cwiseInverse().asDiagonal(), y;
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(all);
  r_ = qr.matrixQR().topRows(all.cols()).triangularView<Eigen::Upper>();
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

double ParameterSelection::rss(const std::vector<Index>& columns) const {
  const Eigen::VectorXd y = r_.col(r_.cols() - 1);
  if (columns.empty()) return y.squaredNorm();
  const Eigen::MatrixXd x = picked(r_, columns);
  return (y - x * x.colPivHouseholderQr().solve(y)).squaredNorm();
}

double ParameterSelection::two_sided_p(double rss_without, double rss_with,
                                       std::size_t columns) const {
  const double dof = rows_ - static_cast<double>(columns);
  if (!(dof > 0) || !(rss_with > 0)) return 1;
  const double t = std::sqrt(std::max(0.0, rss_without - rss_with) / (rss_with / dof));
  const auto offered = static_cast<double>(std::ranges::count(roles_, Role::offered));
  return std::min(1.0, offered * calibration::t_two_sided_p(t, dof));
}

void ParameterSelection::select(double alpha) {
  // Each entry lowers the residual sum, so the loop ends; twice the columns is beyond what it
  // needs.
  for (std::size_t turn = 0; turn < 2 * roles_.size(); ++turn) {
    const double now = rss(columns_in());
    std::size_t best = kNone;
    double lowest = now;
    for (std::size_t i = 0; i < roles_.size(); ++i) {
      if (roles_[i] != Role::offered || is_in(i)) continue;
      const double with = rss(columns_in(kNone, i));
      if (with < lowest) lowest = with, best = i;
    }
    if (best == kNone || two_sided_p(now, lowest, columns_in(kNone, best).size()) > alpha) return;
    chosen_.push_back(best);
    std::erase_if(chosen_, [&](std::size_t one) { return adjusted_p(one) > alpha; });
    if (std::ranges::find(chosen_, best) == chosen_.end()) return;
  }
}

double ParameterSelection::adjusted_p(std::size_t column) const {
  const auto in = columns_in();
  return two_sided_p(rss(columns_in(column)), rss(in), in.size());
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

Eigen::VectorXd ParameterSelection::coefficients(std::size_t without) const {
  const auto in = columns_in(without);
  const Eigen::VectorXd b = picked(r_, in).colPivHouseholderQr().solve(r_.col(r_.cols() - 1));
  Eigen::VectorXd all = Eigen::VectorXd::Zero(scale_.size());
  for (std::size_t i = 0; i < in.size(); ++i) all[in[i]] = b[static_cast<Index>(i)] / scale_[in[i]];
  return all;
}

Eigen::VectorXd ParameterSelection::standard_errors() const {
  const auto in = columns_in();
  const Eigen::MatrixXd x = picked(r_, in);
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
