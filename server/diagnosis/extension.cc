#include "server/diagnosis/extension.h"

#include <algorithm>
#include <cmath>

#include "server/diagnosis/cancelled.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::size_t kMostContenders = 8;
constexpr int kRounds = 2;
constexpr std::size_t kMostFurther = 2;

Eigen::MatrixXd beside(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  Eigen::MatrixXd both(a.rows(), a.cols() + b.cols());
  both << a, b;
  return both;
}

std::vector<double> values_of(const Named& named) {
  std::vector<double> values = {named.parameter};
  values.insert(values.end(), named.further.begin(), named.further.end());
  return values;
}

// terms: of one value.
std::vector<effects::Term> at_values(const std::vector<effects::Term>& terms,
                                     const std::vector<double>& values) {
  std::vector<effects::Term> result;
  for (const double value : values) {
    const auto there = with_parameter(terms, value);
    result.insert(result.end(), there.begin(), there.end());
  }
  return result;
}

}  // namespace

Extension::Extension(const Problem& problem, const std::vector<Cause>& causes,
                     const Eigen::MatrixXd& series, Search& search,
                     const std::optional<LeverLimits>& levers, std::function<bool()> tick)
    : problem_(problem),
      causes_(causes),
      series_(series),
      search_(search),
      tick_(std::move(tick)),
      plausible_(problem, levers),
      ruled_out_(causes.size(), 0) {
  const auto& time_s = problem.data().time_s;
  for (std::size_t i = 1; i < time_s.size(); ++i)
    if (time_s[i] > time_s[i - 1]) instants_.push_back((time_s[i] + time_s[i - 1]) / 2);
}

Eigen::MatrixXd Extension::learned(std::optional<std::size_t> without) const {
  Eigen::MatrixXd columns = problem_.learned(problem_.base_columns);
  for (std::size_t i = 0; i < named_.size(); ++i)
    if (i != without) columns = beside(columns, named_[i].learned);
  return columns;
}

Eigen::MatrixXd Extension::all(std::optional<std::size_t> without) const {
  Eigen::MatrixXd columns = problem_.base_columns;
  for (std::size_t i = 0; i < named_.size(); ++i)
    if (i != without) columns = beside(columns, named_[i].all);
  return columns;
}

std::vector<char> Extension::allowed() const {
  std::vector<char> allowed(causes_.size(), 1);
  for (std::size_t c = 0; c < causes_.size(); ++c)
    if (ruled_out_[c] != 0) allowed[c] = 0;
  for (const auto& one : named_)
    allowed[one.cause] = has_values(causes_[one.cause]) && one.further.size() < kMostFurther;
  return allowed;
}

Ground Extension::ground(std::optional<std::size_t> without,
                         const std::vector<NoiseShape>& shapes) const {
  return {problem_.timeline, shapes, learned(without), series_};
}

GainOf Extension::gain_of(const Ground& ground, const Cause& cause,
                          std::vector<effects::Term> terms, std::vector<double> values,
                          std::size_t at) const {
  return [this, &ground, on = acts_on(problem_, cause), terms = std::move(terms),
          values = std::move(values), at](double value) mutable {
    if (tick_ && !tick_()) return 0.0;  // whoever asked is to stop
    values[at] = value;
    const auto columns = filled_columns(problem_, at_values(terms, values));
    return columns ? ground.gain(problem_.learned(*columns), on).gain : 0.0;
  };
}

bool Extension::before(const Candidate& a, const Candidate& b) {
  return a.nameable != b.nameable ? a.nameable : a.ln_p < b.ln_p;
}

Extension::Candidate Extension::of_cell(std::size_t cause, std::size_t cell,
                                        const Ground& ground) const {
  const Cause& what = causes_[cause];
  Candidate result{cause, {what.cells[cell].parameter, 0}, 0, {}, what.cells[cell].terms};
  if (what.scale != ParameterScale::none) {
    result.refined = refine(what, result.refined.value, instants_,
                            gain_of(ground, what, result.terms, {result.refined.value}, 0));
    result.terms = with_parameter(result.terms, result.refined.value);
  }
  const auto columns = filled_columns(problem_, result.terms);
  result.nameable = false;
  if (!columns) return result;
  const Eigen::MatrixXd learned = problem_.learned(*columns);
  result.gain = ground.gain(learned, acts_on(problem_, what));
  if (!plausible_.allows(what, result.terms, learned, result.gain.shape, ground)) result.gain = {};
  result.nameable = result.gain.gain > 0 &&
                    plausible_.told_from_geometry(what, learned, result.gain.shape, ground);
  result.refined.gain = result.gain.gain;
  result.ln_p = search_.ln_p(cause, result.gain.gain, result.gain.dof);
  return result;
}

// Where the best cell takes more than the cause can do, the best of those that do not.
Extension::Candidate Extension::refined(std::size_t cause, std::size_t cell,
                                        const Ground& ground) const {
  Candidate best = of_cell(cause, cell, ground);
  const Cause& what = causes_[cause];
  if (best.nameable || what.scale != ParameterScale::none) return best;
  for (std::size_t other = 0; other < what.cells.size(); ++other) {
    if (other == cell) continue;
    Candidate one = of_cell(cause, other, ground);
    if (before(one, best)) best = std::move(one);
  }
  return best;
}

std::vector<Extension::Candidate> Extension::contenders(
    const Look& look, const Ground& ground, const std::vector<std::size_t>& present) const {
  const auto is_present = [&](std::size_t c) {
    return std::ranges::find(present, c) != present.end();
  };
  std::vector<std::size_t> near;
  for (std::size_t c = 0; c < look.causes.size(); ++c)
    if (look.causes[c].gain > 0 &&
        (is_present(c) || look.causes[c].ln_p < look.causes[*look.first].ln_p + kWithinReach_ln_p))
      near.push_back(c);
  std::ranges::stable_sort(near, {}, [&](std::size_t c) { return look.causes[c].ln_p; });
  std::vector<Candidate> result;
  for (std::size_t i = 0; i < near.size(); ++i) {
    if (i >= kMostContenders && !is_present(near[i])) continue;
    result.push_back(refined(near[i], look.causes[near[i]].cell, ground));
    if (tick_ && !tick_()) break;
  }
  std::ranges::stable_sort(result, before);
  return result;
}

Result<Named> Extension::made(const Candidate& candidate, double p_adjusted) const {
  auto columns = filled_columns(problem_, candidate.terms);
  if (!columns) return tl::unexpected(columns.error());
  Named one;
  one.cause = candidate.cause;
  one.terms = candidate.terms;
  one.parameter = candidate.refined.value;
  one.all = std::move(*columns);
  one.learned = problem_.learned(one.all);
  one.p_adjusted = p_adjusted;
  one.gain = candidate.gain.gain;
  one.ln_p = candidate.ln_p;
  return one;
}

Result<void> Extension::add(const Look& look) {
  shapes_ = look.shapes;
  const Ground here = ground({}, shapes_);
  std::vector<std::size_t> present;
  for (const auto& one : named_)
    if (has_values(causes_[one.cause])) present.push_back(one.cause);
  const auto best = contenders(look, here, present);
  if (best.empty()) return cancelled();
  if (!best.front().nameable) {
    for (const auto& candidate : best) ruled_out_[candidate.cause] = 1;
    return {};
  }
  for (const auto& candidate : best)
    if (const auto index = index_of(candidate.cause);
        index && candidate.ln_p < best.front().ln_p + kWithinReach_ln_p)
      return add_value(*index, candidate.refined.value);
  auto one = made(best.front(), look.p_adjusted);
  if (!one) return tl::unexpected(one.error());
  named_.push_back(std::move(*one));
  std::ranges::fill(ruled_out_, char{0});  // beside it, others may be asked for less
  return named_.size() > 1 ? reoptimise() : Result<void>{};
}

Result<void> Extension::reoptimise() {
  for (int round = 0; round < kRounds; ++round)
    for (std::size_t i = 0; i < named_.size(); ++i) {
      const Cause& cause = causes_[named_[i].cause];
      if (cause.scale == ParameterScale::none) continue;
      if (tick_ && !tick_()) return cancelled();
      const Ground here = ground(i, shapes_);
      auto values = values_of(named_[i]);
      for (std::size_t k = 0; k < values.size(); ++k) {
        const auto again = refine(cause, values[k], instants_,
                                  gain_of(here, cause, cause.cells.front().terms, values, k));
        values[k] = again.value;
        named_[i].gain = again.gain;
      }
      if (auto ok = set_values(named_[i], values); !ok) return ok;
    }
  return {};
}

std::optional<std::size_t> Extension::index_of(std::size_t cause) const {
  for (std::size_t i = 0; i < named_.size(); ++i)
    if (named_[i].cause == cause) return i;
  return std::nullopt;
}

Result<void> Extension::set_values(Named& named, const std::vector<double>& values) const {
  named.terms = at_values(causes_[named.cause].cells.front().terms, values);
  auto columns = filled_columns(problem_, named.terms);
  if (!columns) return tl::unexpected(columns.error());
  named.parameter = values.front();
  named.further.assign(values.begin() + 1, values.end());
  named.all = std::move(*columns);
  named.learned = problem_.learned(named.all);
  return {};
}

Result<void> Extension::add_value(std::size_t index, double value) {
  auto values = values_of(named_[index]);
  values.push_back(value);
  if (auto ok = set_values(named_[index], values); !ok) return ok;
  return reoptimise();
}

void Extension::withdraw(std::size_t index) {
  named_.erase(named_.begin() + static_cast<std::ptrdiff_t>(index));
}

Extension::Candidate Extension::as_it_stands(std::size_t index, const Ground& ground) const {
  const Named& named = named_[index];
  Candidate result{named.cause, {named.parameter, 0}, 0, {}, named.terms};
  result.gain = ground.gain(named.learned, acts_on(problem_, causes_[named.cause]));
  result.refined.gain = result.gain.gain;
  result.ln_p = search_.ln_p(named.cause, result.gain.gain, result.gain.dof);
  return result;
}

std::optional<Profile> Extension::profile_of(std::size_t index) const {
  const Named& one = named_[index];
  const Cause& cause = causes_[one.cause];
  if (cause.scale == ParameterScale::none) return std::nullopt;
  const Ground here = ground(index, shapes_);
  const auto gain = gain_of(here, cause, cause.cells.front().terms, values_of(one), 0);
  return profile(cause, {one.parameter, gain(one.parameter)}, instants_, gain);
}

}  // namespace driftwise::diagnosis
