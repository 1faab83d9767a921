#include "server/calibration/stepwise.h"

#include <cmath>

#include "server/calibration/tail.h"

namespace driftwise::calibration {
namespace {

constexpr double kTie = 1e-9;
// Residuals of a few roundings of y: 8 epsilon, squared, is 3e-30. Below, candidates would fit
// rounding errors.
constexpr double kExact = 1e-29;

// The norm of column j's own monomial part; columns of degree 1 are judged by their raw norm, as R
// does.
Eigen::VectorXd own_norms(const Triangle& triangle, const Basis& basis) {
  Eigen::VectorXd norms(triangle.columns.cols());
  for (Eigen::Index j = 0; j < norms.size(); ++j) {
    const auto& expansion = basis.expansions[static_cast<std::size_t>(j)];
    norms[j] = triangle.columns.col(j).norm();
    if (degree(basis.monomials[static_cast<std::size_t>(expansion.top)]) < 2) continue;
    for (const auto& [monomial, value] : expansion.parts)
      if (monomial == expansion.top)
        norms[j] = std::min(norms[j], std::abs(static_cast<double>(value)) *
                                          triangle.monomials.col(monomial).norm());
  }
  return norms;
}

struct Choice {
  int column = -1;
  double f = 0;
};

Choice best_outside(const OrthogonalSet& set, int columns) {
  std::vector<double> f(static_cast<std::size_t>(columns), -1);
  Choice best;
  for (int j = 0; j < columns; ++j) {
    if (set.has(j)) continue;
    const auto statistics = set.outside(j);
    if (!statistics.estimable) continue;
    f[static_cast<std::size_t>(j)] = statistics.f();
    if (best.column < 0 || statistics.f() > best.f) best = {j, statistics.f()};
  }
  for (int j = 0; j < best.column; ++j)  // a tie goes to the lowest column
    if (f[static_cast<std::size_t>(j)] >= best.f * (1 - kTie))
      return {j, f[static_cast<std::size_t>(j)]};
  return best;
}

Choice worst_inside(const OrthogonalSet& set, const std::vector<char>& always) {
  const auto inside = set.inside();
  Choice worst;
  for (std::size_t i = 0; i < inside.size(); ++i) {
    const int column = set.order()[i];
    if (always[static_cast<std::size_t>(column)] != 0) continue;
    if (worst.column < 0 || inside[i].f() < worst.f) worst = {column, inside[i].f()};
  }
  if (worst.column < 0) return worst;
  Choice lowest = worst;
  for (std::size_t i = 0; i < inside.size(); ++i) {
    const int column = set.order()[i];
    if (always[static_cast<std::size_t>(column)] == 0 && column < lowest.column &&
        inside[i].f() <= worst.f * (1 + kTie))
      lowest = {column, inside[i].f()};
  }
  return lowest;
}

}  // namespace

Selection select(const Triangle& triangle, const Basis& basis, const std::vector<char>& always,
                 Eigen::Index output, const SelectionRule& rule) {
  Selection selection{
      OrthogonalSet(triangle.columns, triangle.outputs.col(output), triangle.beyond[output],
                    triangle.rows, own_norms(triangle, basis)),
      {},
      {},
      false,
      false};
  auto& set = selection.set;
  const int columns = static_cast<int>(triangle.columns.cols());
  for (int j = 0; j < columns; ++j) {
    if (rule.stepwise && always[static_cast<std::size_t>(j)] == 0) continue;
    if (!rule.stepwise || (set.dof() > 1 && !set.collinear(j)))
      set.enter(j);
    else
      selection.unestimable.push_back(j);
  }
  const auto record = [&](char action, int column, double p) {
    selection.history.push_back({action, column, p, set.rmse(), set.dof()});
  };
  record('s', -1, 1);
  if (!rule.stepwise) return selection;

  const std::size_t most_steps = 100 + 20 * static_cast<std::size_t>(columns);
  while (selection.history.size() < most_steps) {
    if (set.rss() <= kExact * set.total()) {
      selection.exact = true;
      return selection;
    }
    const Choice in = best_outside(set, columns);
    if (in.column >= 0) {
      const double p = f_upper_p(in.f, 1, set.dof() - 1);
      if (p < rule.p_enter) {
        set.enter(in.column);
        record('e', in.column, p);
        continue;
      }
    }
    const Choice out = worst_inside(set, always);
    if (out.column < 0) return selection;
    const double p = f_upper_p(out.f, 1, set.dof());
    if (!(p > rule.p_remove)) return selection;
    set.remove(out.column);
    record('r', out.column, p);
  }
  selection.cycled = true;
  return selection;
}

}  // namespace driftwise::calibration
