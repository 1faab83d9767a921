#include "server/calibration/selection/stepwise.h"

#include <algorithm>
#include <cmath>

#include "server/calibration/linear/tail.h"

namespace driftwise::calibration {
namespace {

constexpr double kTie = 1e-9;
constexpr double kWorthwhile = 1e-7;  // fall of BIC or AIC, as R's step() asks
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

// Which changes the rule and hierarchy allow now.
class Allowed {
 public:
  Allowed(const SelectionRule& rule, const std::vector<char>& always, Eigen::Index output,
          const OrthogonalSet& set)
      : rule_(rule), always_(always), output_(output), set_(set) {}

  bool entering(int column) const {
    const auto j = static_cast<std::size_t>(column);
    if (set_.has(column) || (!rule_.barred.empty() && rule_.barred[j] != 0) ||
        rule_.leaves_out(output_, column))
      return false;
    return rule_.parents.empty() ||
           std::ranges::all_of(rule_.parents[j], [this](int parent) { return set_.has(parent); });
  }
  bool leaving(int column) const {
    if (always_[static_cast<std::size_t>(column)] != 0) return false;
    return rule_.parents.empty() || std::ranges::none_of(set_.order(), [&](int child) {
             const auto& parents = rule_.parents[static_cast<std::size_t>(child)];
             return std::ranges::find(parents, column) != parents.end();
           });
  }

 private:
  const SelectionRule& rule_;
  const std::vector<char>& always_;
  Eigen::Index output_;
  const OrthogonalSet& set_;
};

struct Choice {
  int column = -1;
  double f = 0;
};

Choice best_outside(const OrthogonalSet& set, int columns, const Allowed& allowed) {
  std::vector<double> f(static_cast<std::size_t>(columns), -1);
  Choice best;
  for (int j = 0; j < columns; ++j) {
    if (!allowed.entering(j)) continue;
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

Choice worst_inside(const OrthogonalSet& set, const Allowed& allowed) {
  const auto inside = set.inside();
  Choice worst;
  for (std::size_t i = 0; i < inside.size(); ++i) {
    const int column = set.order()[i];
    if (!allowed.leaving(column)) continue;
    if (worst.column < 0 || inside[i].f() < worst.f) worst = {column, inside[i].f()};
  }
  if (worst.column < 0) return worst;
  Choice lowest = worst;
  for (std::size_t i = 0; i < inside.size(); ++i) {
    const int column = set.order()[i];
    if (column < lowest.column && inside[i].f() <= worst.f * (1 + kTie) && allowed.leaving(column))
      lowest = {column, inside[i].f()};
  }
  return lowest;
}

// One step of the rule: done, or nothing is left to do.
enum class Step { entered, removed, none };

Step step_by_p(OrthogonalSet& set, int columns, const Allowed& allowed, const SelectionRule& rule,
               SelectionRecord& record) {
  const Choice in = best_outside(set, columns, allowed);
  if (in.column >= 0) {
    record.p = f_upper_p(in.f, 1, set.dof() - 1);
    if (record.p < rule.p_enter) {
      record.column = in.column;
      set.enter(in.column);
      return Step::entered;
    }
  }
  const Choice out = worst_inside(set, allowed);
  if (out.column < 0) return Step::none;
  record.p = f_upper_p(out.f, 1, set.dof());
  if (!(record.p > rule.p_remove)) return Step::none;
  record.column = out.column;
  set.remove(out.column);
  return Step::removed;
}

Step step_by_information(OrthogonalSet& set, int columns, const Allowed& allowed,
                         const SelectionRule& rule, SelectionRecord& record) {
  const double price = price_per_term(rule.criterion, set.rows());
  const Choice out = worst_inside(set, allowed), in = best_outside(set, columns, allowed);
  const double by_leaving =
      out.column < 0 ? HUGE_VAL : change_by_leaving(out.f, set.dof(), set.rows(), price);
  const double by_entering =
      in.column < 0 ? HUGE_VAL : change_by_entering(in.f, set.dof() - 1, set.rows(), price);
  if (std::min(by_leaving, by_entering) >= -kWorthwhile) return Step::none;
  const double tie = kTie * static_cast<double>(set.rows());
  if (by_leaving < -kWorthwhile && by_leaving <= by_entering + tie) {
    record.p = f_upper_p(out.f, 1, set.dof());
    record.column = out.column;
    set.remove(out.column);
    return Step::removed;
  }
  record.p = f_upper_p(in.f, 1, set.dof() - 1);
  record.column = in.column;
  set.enter(in.column);
  return Step::entered;
}

}  // namespace

Selection select(const Triangle& triangle, const Basis& basis, const std::vector<char>& always,
                 Eigen::Index output, const SelectionRule& rule, const std::vector<int>& from) {
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
    if (rule.leaves_out(output, j)) continue;
    if (!rule.stepwise || (set.dof() > 1 && !set.collinear(j)))
      set.enter(j);
    else
      selection.unestimable.push_back(j);
  }
  const Allowed allowed(rule, always, output, set);
  for (const int j : from)
    if (allowed.entering(j) && set.dof() > 2 && !set.collinear(j)) set.enter(j);
  const auto record = [&](SelectionRecord one) {
    one.rmse = set.rmse();
    one.dof = set.dof();
    if (rule.stepwise && rule.criterion != Criterion::p)
      one.value = information(set.rss(), set.rows(), static_cast<std::int64_t>(set.order().size()),
                              price_per_term(rule.criterion, set.rows()));
    selection.history.push_back(one);
  };
  record({});
  if (!rule.stepwise) return selection;

  const std::size_t most_steps = 100 + 20 * static_cast<std::size_t>(columns);
  while (selection.history.size() < most_steps) {
    if (set.rss() <= kExact * set.total()) {
      selection.exact = true;
      return selection;
    }
    SelectionRecord one;
    const Step step = rule.criterion == Criterion::p
                          ? step_by_p(set, columns, allowed, rule, one)
                          : step_by_information(set, columns, allowed, rule, one);
    if (step == Step::none) return selection;
    one.action = step == Step::entered ? 'e' : 'r';
    record(one);
  }
  selection.cycled = true;
  return selection;
}

}  // namespace driftwise::calibration
