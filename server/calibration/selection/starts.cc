#include "server/calibration/selection/starts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace driftwise::calibration {
namespace {

constexpr double kSameValue = 1e-7;

struct Start {
  std::string name;
  std::vector<int> columns;
};

std::vector<int> candidates_of(const SelectionRule& rule, const std::vector<char>& always) {
  std::vector<int> candidates;
  for (std::size_t j = 0; j < always.size(); ++j)
    if (always[j] == 0 && (rule.barred.empty() || rule.barred[j] == 0))
      candidates.push_back(static_cast<int>(j));
  return candidates;
}

// Parents before children, each once: select() takes a child only after its parents.
void add_with_parents(const SelectionRule& rule, int column, std::vector<char>& taken,
                      std::vector<int>& order) {
  auto& mark = taken[static_cast<std::size_t>(column)];
  if (mark != 0) return;
  mark = 1;
  if (!rule.parents.empty())
    for (const int parent : rule.parents[static_cast<std::size_t>(column)])
      add_with_parents(rule, parent, taken, order);
  order.push_back(column);
}

std::vector<int> with_parents(const SelectionRule& rule, const std::vector<char>& always,
                              const std::vector<int>& columns) {
  std::vector<char> taken = always;
  std::vector<int> order;
  for (const int column : columns) add_with_parents(rule, column, taken, order);
  return order;
}

std::vector<Start> starts_of(const Triangle& triangle, const SelectionRule& rule,
                             const std::vector<char>& always) {
  const std::vector<int> candidates = candidates_of(rule, always);
  const auto certain = std::ranges::count(always, 1);
  // Terms beyond the certain ones that leave at least two degrees of freedom.
  const auto room = static_cast<double>(triangle.rows - certain - 2);
  std::vector<Start> starts{{"none", {}}};
  if (room >= static_cast<double>(candidates.size()) && rule.starts > 1)
    starts.push_back({"all", with_parents(rule, always, candidates)});
  const double share =
      std::clamp(room / 2 / std::max<double>(1, static_cast<double>(candidates.size())), 0.0, 0.5);
  // The engine's numbers are fixed by the standard, those of its distributions are not.
  std::mt19937_64 random(static_cast<std::uint64_t>(rule.seed));
  while (static_cast<int>(starts.size()) < rule.starts) {
    std::vector<int> columns;
    for (const int column : candidates)
      if (std::ldexp(static_cast<double>(random() >> 11), -53) < share) columns.push_back(column);
    starts.push_back(
        {"random " + std::to_string(starts.size() + 1), with_parents(rule, always, columns)});
  }
  return starts;
}

}  // namespace

BestSelection select_from_starts(const Triangle& triangle, const Basis& basis,
                                 const std::vector<char>& always, Eigen::Index output,
                                 const SelectionRule& rule, const Executor& executor) {
  if (!rule.stepwise || rule.starts < 2) return {select(triangle, basis, always, output, rule), {}};
  const std::vector<Start> starts = starts_of(triangle, rule, always);
  std::vector<std::optional<Selection>> found(starts.size());
  const auto job = [&](std::size_t i) {
    found[i].emplace(select(triangle, basis, always, output, rule, starts[i].columns));
  };
  if (executor)
    executor(starts.size(), job);
  else
    for (std::size_t i = 0; i < starts.size(); ++i) job(i);

  const double price = price_per_term(rule.criterion, triangle.rows);
  const auto certain = static_cast<int>(std::ranges::count(always, 1));
  std::vector<StartOutcome> outcomes;
  std::size_t best = 0;
  double lowest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const auto& set = found[i]->set;
    const auto terms = static_cast<int>(set.order().size());
    const auto value =
        found[i]->exact ? std::nullopt : information(set.rss(), set.rows(), terms, price);
    outcomes.push_back({starts[i].name, static_cast<int>(starts[i].columns.size()), terms - certain,
                        set.rmse(), value, false});
    // Among exact fits the fewest terms win.
    const double rank = value ? *value : -1e300 + terms * 1e290;
    if (!(rank < lowest - kSameValue)) continue;
    lowest = rank;
    best = i;
  }
  outcomes[best].won = true;
  return {std::move(*found[best]), std::move(outcomes)};
}

}  // namespace driftwise::calibration
