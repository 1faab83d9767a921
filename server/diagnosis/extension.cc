#include "server/diagnosis/extension.h"

#include <algorithm>
#include <cmath>

#include "server/diagnosis/cancelled.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kWithinReach_ln_p = 6;  // before refinement, of the best
constexpr std::size_t kMostContenders = 8;
constexpr double kRival_ln_p = 3;           // 6 in 2 ln L
constexpr double kRivalCorrelation = 0.95;  // of fitted contributions, whitened
constexpr double kNoticed_ln_p = -7;        // nobody is a rival who would not be noticed alone
constexpr double kSuperfluous_ln_p = -4;    // a finding that the others explain
constexpr int kRounds = 2;

Eigen::MatrixXd beside(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  Eigen::MatrixXd both(a.rows(), a.cols() + b.cols());
  both << a, b;
  return both;
}

double correlation(const Gain& a, const Gain& b) {
  double across = 0, aa = 0, bb = 0;
  for (std::size_t o = 0; o < a.contribution.size(); ++o) {
    const auto &u = a.contribution[o], &v = b.contribution[o];
    if (u.size() > 0) aa += u.squaredNorm();
    if (v.size() > 0) bb += v.squaredNorm();
    if (u.size() > 0 && v.size() > 0) across += u.dot(v);
  }
  return aa > 0 && bb > 0 ? across / std::sqrt(aa * bb) : 0;
}

}  // namespace

Extension::Extension(const Problem& problem, const std::vector<Cause>& causes,
                     const Eigen::MatrixXd& series, Search& search, std::function<bool()> tick)
    : problem_(problem), causes_(causes), series_(series), search_(search), tick_(std::move(tick)) {
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
  for (const auto& one : named_) allowed[one.cause] = 0;
  return allowed;
}

Ground Extension::ground(std::optional<std::size_t> without,
                         const std::vector<NoiseShape>& shapes) const {
  return {problem_.timeline, shapes, learned(without), series_};
}

GainOf Extension::gain_of(const Ground& ground, const Cause& cause,
                          const std::vector<effects::Term>& terms) const {
  return [this, &ground, on = acts_on(problem_, cause), terms](double value) {
    if (tick_ && !tick_()) return 0.0;  // whoever asked is to stop
    const auto columns = filled_columns(problem_, with_parameter(terms, value));
    return columns ? ground.gain(problem_.learned(*columns), on).gain : 0.0;
  };
}

Extension::Candidate Extension::refined(std::size_t cause, std::size_t cell,
                                        const Ground& ground) const {
  const Cause& what = causes_[cause];
  Candidate result{cause, {what.cells[cell].parameter, 0}, 0, {}, what.cells[cell].terms};
  if (what.scale != ParameterScale::none) {
    result.refined =
        refine(what, result.refined.value, instants_, gain_of(ground, what, result.terms));
    result.terms = with_parameter(result.terms, result.refined.value);
  }
  if (const auto columns = filled_columns(problem_, result.terms))
    result.gain = ground.gain(problem_.learned(*columns), acts_on(problem_, what));
  result.refined.gain = result.gain.gain;
  result.ln_p = search_.ln_p(cause, result.gain.gain, result.gain.dof);
  return result;
}

std::vector<Extension::Candidate> Extension::contenders(const Look& look, const Ground& ground,
                                                        std::optional<std::size_t> present) const {
  std::vector<std::size_t> near;
  for (std::size_t c = 0; c < look.causes.size(); ++c)
    if (look.causes[c].gain > 0 &&
        (c == present || look.causes[c].ln_p < look.causes[*look.first].ln_p + kWithinReach_ln_p))
      near.push_back(c);
  std::ranges::stable_sort(near, {}, [&](std::size_t c) { return look.causes[c].ln_p; });
  std::vector<Candidate> result;
  for (std::size_t i = 0; i < near.size(); ++i) {
    if (i >= kMostContenders && near[i] != present) continue;
    result.push_back(refined(near[i], look.causes[near[i]].cell, ground));
    if (tick_ && !tick_()) break;
  }
  std::ranges::stable_sort(result, {}, &Candidate::ln_p);
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
  const auto best = contenders(look, here, {});
  if (best.empty()) return cancelled();
  auto one = made(best.front(), look.p_adjusted);
  if (!one) return tl::unexpected(one.error());
  named_.push_back(std::move(*one));
  return named_.size() > 1 ? reoptimise() : Result<void>{};
}

Result<void> Extension::reoptimise() {
  for (int round = 0; round < kRounds; ++round)
    for (std::size_t i = 0; i < named_.size(); ++i) {
      const Cause& cause = causes_[named_[i].cause];
      if (cause.scale == ParameterScale::none) continue;
      if (tick_ && !tick_()) return cancelled();
      const Ground here = ground(i, shapes_);
      Candidate again{named_[i].cause, {}, 0, {}, named_[i].terms};
      const auto gain = gain_of(here, cause, again.terms);
      again.refined = refine(cause, named_[i].parameter, instants_, gain);
      again.terms = with_parameter(again.terms, again.refined.value);
      again.gain.gain = again.refined.gain;
      again.ln_p = named_[i].ln_p;
      auto one = made(again, named_[i].p_adjusted);
      if (!one) return tl::unexpected(one.error());
      named_[i] = std::move(*one);
    }
  return {};
}

void Extension::withdraw(std::size_t index) {
  named_.erase(named_.begin() + static_cast<std::ptrdiff_t>(index));
}

Result<std::vector<std::string>> Extension::settle() {
  std::vector<std::string> said;
  for (std::size_t i = 0; i < named_.size();) {
    auto allowed = this->allowed();
    allowed[named_[i].cause] = 1;
    const auto look = search_.compare(learned(i), allowed);
    if (!look) return cancelled();
    if (!look->first) {
      withdraw(i);
      continue;
    }
    shapes_ = look->shapes;
    const Ground here = ground(i, shapes_);
    const auto best = contenders(*look, here, named_[i].cause);
    if (best.empty()) return cancelled();
    if (best.front().ln_p > kSuperfluous_ln_p) {
      said.push_back(name_of(causes_[named_[i].cause]) +
                     " was named and is explained by what was found after it");
      withdraw(i);
      continue;
    }
    auto one = made(best.front(), named_[i].p_adjusted);
    if (!one) return tl::unexpected(one.error());
    if (one->cause != named_[i].cause)
      said.push_back(name_of(causes_[named_[i].cause]) + " was named first; with the rest known, " +
                     name_of(causes_[one->cause]) + " explains more");
    for (std::size_t k = 1; k < best.size(); ++k)
      if (best[k].ln_p < one->ln_p + kRival_ln_p ||
          (best[k].ln_p < kNoticed_ln_p &&
           correlation(best[k].gain, best.front().gain) > kRivalCorrelation))
        one->rivals.push_back(best[k].cause);
    named_[i] = std::move(*one);
    ++i;
  }
  return said;
}

std::optional<Profile> Extension::profile_of(std::size_t index) const {
  const Named& one = named_[index];
  const Cause& cause = causes_[one.cause];
  if (cause.scale == ParameterScale::none) return std::nullopt;
  const Ground here = ground(index, shapes_);
  const auto gain = gain_of(here, cause, one.terms);
  return profile(cause, {one.parameter, gain(one.parameter)}, instants_, gain);
}

}  // namespace driftwise::diagnosis
