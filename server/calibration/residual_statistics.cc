#include "server/calibration/residual_statistics.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace driftwise::calibration {
namespace {

using Eigen::Index;
using Groups = std::map<std::vector<double>, std::vector<Index>>;

constexpr double kSamePose = 1e-3;  // of a channel's range
constexpr double kWidestPose =
    1e-2;  // a chain of neighbours longer than this is a continuum, not a repeated pose

Index monomial_of(const Design& design, int variable) {
  const Monomial wanted = {{variable, 1}};
  const auto at = std::ranges::find(design.basis.monomials, wanted);
  return at == design.basis.monomials.end() ? -1 : at - design.basis.monomials.begin();
}

// A label per row: rows whose values differ by less than a step share it. Empty: the values form a
// continuum.
std::vector<double> labels(const Eigen::VectorXd& u) {
  std::vector<Index> order(static_cast<std::size_t>(u.size()));
  std::iota(order.begin(), order.end(), Index{0});
  std::ranges::sort(order, {}, [&u](Index row) { return u[row]; });
  const double range = u[order.back()] - u[order.front()];
  std::vector<double> label(order.size());
  double start = u[order.front()], last = start;
  for (const Index row : order) {
    if (u[row] - last > kSamePose * range) start = u[row];
    if (u[row] - start > kWidestPose * range) return {};
    last = u[row];
    label[static_cast<std::size_t>(row)] = start;
  }
  return label;
}

std::optional<PureError> from_exact_repeats(const Design& design, Index output) {
  const Index m = design.monomials();
  Groups groups;
  for (Index row = 0; row < design.matrix.rows(); ++row) {
    std::vector<double> key(static_cast<std::size_t>(m));
    for (Index j = 0; j < m; ++j) key[static_cast<std::size_t>(j)] = design.matrix(row, j);
    groups[std::move(key)].push_back(row);
  }
  if (groups.size() == static_cast<std::size_t>(design.matrix.rows())) return std::nullopt;
  PureError result{0, 0, true};
  double squares = 0;
  for (const auto& [key, rows] : groups) {
    double mean = 0;
    for (const Index row : rows) mean += design.matrix(row, m + output);
    mean /= static_cast<double>(rows.size());
    for (const Index row : rows) squares += std::pow(design.matrix(row, m + output) - mean, 2);
    result.dof += static_cast<int>(rows.size()) - 1;
  }
  result.sd = std::sqrt(squares / result.dof);
  return result;
}

std::optional<PureError> from_repeated_poses(const Design& design,
                                             const Eigen::VectorXd& residuals) {
  std::vector<std::vector<double>> keys(design.rows.size());
  bool any_pose = false;
  for (std::size_t v = 0; v < design.variables.size(); ++v) {
    if (!is_pose_symbol(design.variables[v].name) ||
        design.variables[v].max == design.variables[v].min)
      continue;
    const Index column = monomial_of(design, static_cast<int>(v));
    if (column < 0) continue;
    const auto label = labels(design.matrix.col(column));
    if (label.empty()) return std::nullopt;
    any_pose = true;
    for (std::size_t row = 0; row < keys.size(); ++row) keys[row].push_back(label[row]);
  }
  if (!any_pose) return std::nullopt;
  Groups groups;
  for (std::size_t row = 0; row < keys.size(); ++row) {
    keys[row].push_back(design.datum[row]);
    groups[keys[row]].push_back(static_cast<Index>(row));
  }
  PureError result;
  double squares = 0;
  for (const auto& [key, rows] : groups) {
    for (std::size_t i = 1; i < rows.size(); ++i) {
      squares += std::pow(residuals[rows[i]] - residuals[rows[i - 1]], 2) / 2;
      ++result.dof;
    }
  }
  if (result.dof < 3) return std::nullopt;
  result.sd = std::sqrt(squares / result.dof);
  return result;
}

}  // namespace

double standard_deviation(const Eigen::Ref<const Eigen::VectorXd>& values) {
  if (values.size() < 2) return 0;
  return std::sqrt((values.array() - values.mean()).square().sum() /
                   static_cast<double>(values.size() - 1));
}

double lag1_autocorrelation(const Eigen::Ref<const Eigen::VectorXd>& residuals) {
  const Index n = residuals.size();
  if (n < 3) return 0;
  const Eigen::VectorXd centred = residuals.array() - residuals.mean();
  const double squares = centred.squaredNorm();
  return squares > 0 ? centred.head(n - 1).dot(centred.tail(n - 1)) / squares : 0;
}

double effective_rows(std::int64_t rows, double lag1) {
  const auto n = static_cast<double>(rows);
  return std::clamp(n * (1 - lag1) / (1 + lag1), std::min(1.0, n), n);
}

std::optional<PureError> pure_error(const Design& design, Index output,
                                    const Eigen::VectorXd& residuals) {
  if (design.weighted || design.rows.size() < 3) return std::nullopt;
  if (auto exact = from_exact_repeats(design, output)) return exact;
  return from_repeated_poses(design, residuals);
}

}  // namespace driftwise::calibration
