#include "server/diagnosis/growth/left_over.h"

#include <algorithm>

#include "server/core/reasons.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kShareLeft = 0.2;   // of what a finding explains
constexpr double kSuperfluous = 10;  // 2 ln L: what a finding adds to the free shape

Problem with_all_rows(const Problem& problem, std::size_t longest) {
  Problem whole = problem;
  whole.learn.insert(whole.learn.end(), whole.judge.begin(), whole.judge.end());
  whole.judge.clear();
  whole.folds.clear();
  std::ranges::sort(whole.learn);
  whole.learn.erase(std::ranges::unique(whole.learn).begin(), whole.learn.end());
  whole.lay_blocks(longest);
  return whole;
}

// x, x^3, sin(x, ..): of this axis and nothing else.
bool reads_only(const effects::Term& term, const std::string& axis) {
  const auto read = effects::symbols_of(term);
  return read.size() == 1 && *read.begin() == axis;
}

// x:t05, x:drift(): in proportion to this axis.
bool is_scale_of(const effects::Term& term, const std::string& axis) {
  return term.factors.size() > 1 && std::ranges::any_of(term.factors, [&](const auto& factor) {
           const auto* power = std::get_if<effects::Power>(&factor);
           return power != nullptr && power->symbol == axis && power->exponent == 1;
         });
}

Eigen::MatrixXd beside_each_other(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  Eigen::MatrixXd both(a.rows(), a.cols() + b.cols());
  both << a, b;
  return both;
}

}  // namespace

Remainder::Remainder(const Problem& problem, std::size_t longest, const Physics& physics,
                     const std::vector<std::string>& excluded, SearchOptions options)
    : whole_(with_all_rows(problem, longest)),
      series_(whole_.series()),
      shapes_(free_shapes(whole_, physics, excluded)),
      search_(whole_.timeline, series_, shapes_.bank, std::move(options)) {}

SoftBase Remainder::whole_base(SoftBase base) const {
  base.columns = whole_.learned(base.columns);
  return base;
}

double Remainder::left_of(const Extension& extension) const {
  const auto& cell = shapes_.bank.cells[shapes_.bank.entries[*last_->first].first];
  const Ground ground(whole_.timeline, last_->shapes, whole_base(extension.all()), series_);
  return ground
      .free_gain(shapes_.bank.columns.middleCols(cell.first, cell.count),
                 std::vector<char>(whole_.outputs.size(), 1))
      .gain;
}

Result<std::optional<LeftOver>> Remainder::look(const Extension& extension) {
  if (shapes_.variables.empty()) return std::optional<LeftOver>{};
  last_ = search_.look(whole_base(extension.all()), std::vector<char>(shapes_.variables.size(), 1));
  if (!last_) return fail(ErrorCode::cancelled, reasons::kCancelled, "the diagnosis was cancelled");
  if (!last_->first) return std::optional<LeftOver>{};
  return std::optional<LeftOver>{{shapes_.variables[*last_->first], last_->p_adjusted}};
}

std::optional<std::size_t> Remainder::nearest_name(const Extension& extension) const {
  if (!last_ || !last_->first) return std::nullopt;
  const auto& cell = shapes_.bank.cells[shapes_.bank.entries[*last_->first].first];
  const Eigen::MatrixXd shape = shapes_.bank.columns.middleCols(cell.first, cell.count);
  const double left = left_of(extension);
  const std::vector<char> on(whole_.outputs.size(), 1);
  for (std::size_t i = 0; i < extension.named().size(); ++i) {
    const Ground without(whole_.timeline, last_->shapes, whole_base(extension.all(i)), series_);
    const Eigen::MatrixXd own = whole_.learned(extension.named()[i].all);
    const Eigen::MatrixXd both = beside_each_other(shape, own);
    const double by_shape = without.free_gain(shape, on).gain;
    const double by_both = without.free_gain(both, on).gain;
    const double by_finding = without.free_gain(own, on).gain;
    if (by_both - by_shape < kSuperfluous && left > kShareLeft * by_finding) return i;
  }
  return std::nullopt;
}

std::vector<std::size_t> Remainder::spelled_out(const Extension& extension) const {
  static const std::string kWithTime = " with time";
  if (!last_) return {};
  const auto& named = extension.named();
  const std::vector<char> on(whole_.outputs.size(), 1);
  for (std::size_t v = 0; v < shapes_.variables.size(); ++v) {
    const std::string& variable = shapes_.variables[v];
    const bool scale = variable.ends_with(kWithTime);
    const std::string axis =
        scale ? variable.substr(0, variable.size() - kWithTime.size()) : variable;
    if (!is_pose_symbol(axis)) continue;
    std::vector<std::size_t> group;
    std::size_t values = 0;
    Eigen::MatrixXd rest = whole_.base_columns, own(rest.rows(), 0);
    for (std::size_t i = 0; i < named.size(); ++i) {
      const bool belongs = std::ranges::all_of(named[i].terms, [&](const effects::Term& term) {
        return scale ? is_scale_of(term, axis) : reads_only(term, axis);
      });
      (belongs ? own : rest) = beside_each_other(belongs ? own : rest, named[i].all);
      if (!belongs) continue;
      group.push_back(i);
      values += named[i].values.size();
    }
    if (values < 2) continue;
    const auto& cell = shapes_.bank.cells[shapes_.bank.entries[v].first];
    const Ground without(whole_.timeline, last_->shapes, whole_.learned(rest), series_);
    const double by_shape =
        without.free_gain(shapes_.bank.columns.middleCols(cell.first, cell.count), on).gain;
    if (without.free_gain(whole_.learned(own), on).gain - by_shape < kSuperfluous) return group;
  }
  return {};
}

}  // namespace driftwise::diagnosis
