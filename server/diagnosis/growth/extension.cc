#include "server/diagnosis/growth/extension.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "server/core/try.h"
#include "server/core/units.h"
#include "server/diagnosis/answer/cancelled.h"
#include "server/diagnosis/rows/aliases.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::size_t kMostContenders = 8;
constexpr int kRounds = 2;
constexpr std::size_t kMostFurther = 2;
constexpr double kLeastWhite = 1e-3;      // of what neighbours differ by: data without noise
constexpr double kJumpsBesideValues = 5;  // times what the strongest cause with values may leave

Eigen::MatrixXd beside(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  Eigen::MatrixXd both(a.rows(), a.cols() + b.cols());
  both << a, b;
  return both;
}

std::vector<effects::Term> terms_of(const std::vector<Cell>& values) {
  std::vector<effects::Term> result;
  for (const auto& value : values)
    result.insert(result.end(), value.terms.begin(), value.terms.end());
  return result;
}

Cell at_value(const Cell& cell, double value) {
  return {value, with_parameter(cell.terms, value), cell.weight};
}

}  // namespace

Extension::Extension(const Problem& problem, const std::vector<Cause>& causes,
                     const Eigen::MatrixXd& series, Search& search, const Physics& physics,
                     std::function<bool()> tick)
    : problem_(problem),
      causes_(causes),
      series_(series),
      search_(search),
      tick_(std::move(tick)),
      physics_(physics),
      told_from_geometry_(problem),
      gate_(problem, series, search.bank()),
      ruled_out_(causes.size(), 0),
      forbidden_(causes.size(), 0) {
  for (std::size_t o = 0; o < problem.outputs.size(); ++o) {
    between_neighbours_.push_back(physics.between_neighbours(o));
    white_sd_.push_back({between_neighbours_.back()});
  }
  // What readings hide has a prior before anything is named.
  if (problem.hidden.columns.cols() > 0) update_noise();
  const auto& time_s = problem.data().time_s;
  for (std::size_t i = 1; i < time_s.size(); ++i)
    if (time_s[i] > time_s[i - 1]) instants_.push_back((time_s[i] + time_s[i - 1]) / 2);
}

SoftBase Extension::learned(std::optional<std::size_t> without) const {
  SoftBase base = all(without);
  base.columns = problem_.learned(base.columns);
  return base;
}

SoftBase Extension::all(std::optional<std::size_t> without) const {
  SoftBase base(problem_.base_columns, Eigen::VectorXd::Zero(problem_.base_columns.cols()));
  if (const auto& [columns, sd] = problem_.hidden; columns.cols() > 0) {
    base.columns = beside(base.columns, columns);
    base.precision = (Eigen::VectorXd(base.columns.cols()) << base.precision,
                      Physics::shared_precision(sd, white_sd_))
                         .finished();
    base.hidden = columns.cols();
  }
  return with_named(std::move(base), without);
}

SoftBase Extension::with_named(SoftBase base, std::optional<std::size_t> without) const {
  for (std::size_t i = 0; i < named_.size(); ++i) {
    if (i == without) continue;
    base.columns = beside(base.columns, named_[i].all);
    Eigen::VectorXd precision(base.columns.cols());
    precision << base.precision, Physics::shared_precision(named_[i].prior.typical, white_sd_);
    base.precision = std::move(precision);
  }
  return base;
}

bool Extension::is_said_of(std::size_t index, const std::string& motor) const {
  const Named& one = named_[index];
  return may_act_on(causes_[one.cause], motor) &&
         std::ranges::find(one.not_of, motor) == one.not_of.end();
}

SoftBase Extension::described_by(std::size_t output,
                                 const std::function<double(double)>& precision_of,
                                 std::optional<std::size_t> without,
                                 const std::string& motor) const {
  SoftBase base(problem_.base_columns, Eigen::VectorXd::Zero(problem_.base_columns.cols()));
  for (std::size_t i = 0; i < named_.size(); ++i) {
    if (i == without || (!motor.empty() && !is_said_of(i, motor))) continue;
    const Eigen::VectorXd sd =
        named_[i].share[output] * named_[i].prior.typical.col(static_cast<Eigen::Index>(output));
    base.columns = beside(base.columns, named_[i].all);
    Eigen::VectorXd precision(base.columns.cols());
    precision << base.precision,
        sd.unaryExpr([&](double one) { return one > 0 ? precision_of(one) : 1e300; });
    base.precision = std::move(precision);
  }
  return base;
}

SoftBase Extension::described(std::size_t output, std::optional<std::size_t> without,
                              const std::string& motor) const {
  const double noise = between_neighbours_[output];
  return described_by(
      output, [noise](double sd) { return std::pow(noise / sd, 2); }, without, motor);
}

SoftBase Extension::described_whitened(std::size_t output, WhiteSd noise) const {
  return described_by(
      output, [noise](double sd) { return whitened_precision(noise, sd); }, {}, "");
}

std::vector<char> Extension::allowed() const {
  std::vector<char> allowed(causes_.size(), 1);
  for (std::size_t c = 0; c < causes_.size(); ++c)
    if (ruled_out_[c] != 0 || forbidden_[c] != 0) allowed[c] = 0;
  // A strong lag leaves what jumps spell out: the first jump may be named beside it, no second.
  const double least = kJumpsBesideValues * misfit().likelihood;
  for (const auto& one : named_) {
    const Cause& cause = causes_[one.cause];
    const bool may = has_values(cause) || (may_repeat(cause) && one.likelihood >= least);
    allowed[one.cause] = allowed[one.cause] != 0 && may && one.values.size() <= kMostFurther;
  }
  return allowed;
}

Ground Extension::ground(std::optional<std::size_t> without,
                         const std::vector<NoiseShape>& shapes) const {
  return {problem_.timeline, shapes, learned(without), series_};
}

GainOf Extension::gain_of(const Ground& ground, const Cause& cause, std::vector<Cell> values,
                          std::size_t at) const {
  return [this, &ground, &cause, values = std::move(values), at](double value) mutable {
    if (tick_ && !tick_()) return 0.0;  // whoever asked is to stop
    values[at] = at_value(values[at], value);
    const auto here = terms_of(values);
    const auto columns = searched_columns(problem_, here);
    if (!columns) return 0.0;
    const Eigen::MatrixXd learned = problem_.learned(*columns);
    return ground.gain(learned, physics_.prior(cause, here, value, learned).typical).gain;
  };
}

bool Extension::before(const Candidate& a, const Candidate& b) {
  return a.nameable != b.nameable ? a.nameable : a.evidence > b.evidence;
}

// Of a cause that is named: another value of a time constant that does about as well as a new cause
// is the likelier. A jump is no likelier for there being one already.
bool Extension::comes_near(const Candidate& candidate, const Candidate& best) const {
  const double reach = has_values(causes_[candidate.cause]) ? kWithinReach : 0;
  return candidate.evidence >= best.evidence - reach;
}

bool Extension::within_range(const Candidate& candidate, const Eigen::MatrixXd& columns,
                             const Ground& ground) const {
  for (Eigen::Index o = 0; o < ground.outputs(); ++o) {
    if ((candidate.prior.typical.col(o).array() <= 0).all()) continue;
    const auto found = ground.amplitudes(columns, candidate.prior.typical,
                                         candidate.gain.shape[static_cast<std::size_t>(o)], o);
    for (Eigen::Index k = 0; k < found.mean.size(); ++k)
      if (std::abs(found.mean[k]) - 2 * found.error[k] > candidate.prior.range(k, o)) return false;
  }
  return true;
}

Extension::Candidate Extension::of_cell(std::size_t cause, std::size_t cell,
                                        const Standing& standing, const Ground& ground) const {
  const Cause& what = causes_[cause];
  Candidate result{.cause = cause,
                   .refined = {what.cells[cell].parameter, 0},
                   .gain = {},
                   .terms = what.cells[cell].terms,
                   .prior = {}};
  if (what.scale != ParameterScale::none) {
    result.refined =
        refine(what, result.refined.value, instants_, gain_of(ground, what, {what.cells[cell]}, 0));
    result.terms = with_parameter(result.terms, result.refined.value);
  }
  const auto columns = searched_columns(problem_, result.terms);
  result.nameable = false;
  if (!columns) return result;
  const Eigen::MatrixXd learned = problem_.learned(*columns);
  result.prior = physics_.prior(what, result.terms, result.refined.value, learned);
  result.gain = ground.settled_gain(learned, result.prior.typical);
  result.refined.gain = result.gain.gain;
  result.nameable =
      result.gain.gain > 0 && within_range(result, learned, ground) &&
      told_from_geometry_(what, result.refined.value, learned, result.gain.shape, ground);
  result.evidence = result.gain.gain + standing.occam();
  result.beyond = result.evidence + standing.over_chance();
  return result;
}

// Where the best cell takes more than the cause can do, the best of those that do not.
Extension::Candidate Extension::refined(std::size_t cause, const Standing& standing,
                                        const Ground& ground) const {
  Candidate best = of_cell(cause, standing.cell, standing, ground);
  const Cause& what = causes_[cause];
  if (best.nameable || what.scale != ParameterScale::none) return best;
  for (std::size_t other = 0; other < what.cells.size(); ++other) {
    if (other == standing.cell) continue;
    Candidate one = of_cell(cause, other, standing, ground);
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
        (is_present(c) ||
         look.causes[c].evidence > look.causes[*look.first].evidence - kWithinReach))
      near.push_back(c);
  std::ranges::stable_sort(near, std::ranges::greater{},
                           [&](std::size_t c) { return look.causes[c].evidence; });
  std::vector<Candidate> result;
  for (std::size_t i = 0; i < near.size(); ++i) {
    if (i >= kMostContenders && !is_present(near[i])) continue;
    result.push_back(refined(near[i], look.causes[near[i]], ground));
    if (tick_ && !tick_()) break;
  }
  std::ranges::stable_sort(result, before);
  return result;
}

Result<Named> Extension::made(const Candidate& candidate, double p_adjusted) const {
  DRIFTWISE_TRY(auto columns, searched_columns(problem_, candidate.terms));
  Named one;
  one.cause = candidate.cause;
  one.terms = candidate.terms;
  one.values = {{candidate.refined.value, candidate.terms}};
  one.all = std::move(columns);
  one.learned = problem_.learned(one.all);
  one.p_adjusted = std::max(p_adjusted, kSmallestP);
  one.prior = candidate.prior;
  one.evidence = candidate.evidence;
  one.likelihood = candidate.gain.likelihood;
  one.share = candidate.gain.share;
  return one;
}

Gain Extension::gain_where_it_acts(std::size_t index, const Ground& without,
                                   std::optional<std::size_t> but) const {
  const Named& one = named_[index];
  PriorSd prior = one.prior.typical;
  for (std::size_t o = 0; o < one.share.size(); ++o)
    if (one.share[o] == 0 || o == but) prior.col(static_cast<Eigen::Index>(o)).setZero();
  return without.gain(one.learned, prior);
}

void Extension::forbid(std::size_t cause) {
  forbidden_[cause] = 1;
  if (const auto index = index_of(cause)) withdraw(*index);
}

GateScore Extension::gate_score(const Candidate& candidate, const Ground& ground,
                                const SoftBase& base) const {
  std::vector<NoiseShape> noise;
  std::vector<double> sd;
  for (std::size_t o = 0; o < candidate.gain.shape.size(); ++o) {
    noise.push_back(ground.shape(candidate.gain.shape[o]));
    sd.push_back(ground.white_sd_with(candidate.gain, static_cast<Eigen::Index>(o)).value);
  }
  return gate_.judge(base, noise, sd, causes_[candidate.cause], candidate.cause);
}

Result<bool> Extension::add(const Look& look) {
  shapes_ = look.shapes;
  const Ground here = ground({}, shapes_);
  std::vector<std::size_t> present;
  for (const auto& one : named_)
    if (may_repeat(causes_[one.cause])) present.push_back(one.cause);
  const auto best = contenders(look, here, present);
  if (best.empty()) {
    if (tick_ && !tick_()) return cancelled();
    ruled_out_[*look.first] = 1;  // less unlikely than chance makes it, and yet no gain
    return false;
  }
  if (!best.front().nameable) {
    for (const auto& candidate : best) ruled_out_[candidate.cause] = 1;
    return false;
  }
  for (const auto& candidate : best)
    if (const auto index = index_of(candidate.cause);
        index && comes_near(candidate, best.front())) {
      const std::size_t before = named_[*index].values.size();
      DRIFTWISE_RETURN_IF_ERROR(add_value(*index, candidate));
      if (named_[*index].values.size() > before) return true;
      ruled_out_[candidate.cause] = 1;  // the value came to lie on another
      return false;
    }
  const Cause& cause = causes_[best.front().cause];
  const GateScore score = gate_score(best.front(), here, learned());
  if (!score.passes()) {
    ruled_out_[best.front().cause] = 1;
    char figures[96];
    std::snprintf(figures, sizeof figures, "2 ln of the predictive density %+.3g by %s",
                  score.by_time.value_or(1) > 0 ? *score.by_places : *score.by_time,
                  score.by_time.value_or(1) > 0 ? "groups of places" : "blocks of time");
    refused_.push_back(name_of(cause) +
                       " was not named: rows left out are predicted worse with it (" + figures +
                       ")");
    return false;
  }
  DRIFTWISE_TRY(auto one, made(best.front(), look.p_adjusted));
  named_.push_back(std::move(one));
  update_noise();
  std::ranges::fill(ruled_out_, char{0});  // beside it, others may be asked for less
  if (named_.size() > 1) DRIFTWISE_RETURN_IF_ERROR(reoptimise());
  return true;
}

// A strong effect is noise as long as it is not named: with that noise its own prior would hold its
// amplitude back, and what was held back would be left over.
void Extension::update_noise() {
  const Eigen::MatrixXd columns = all().columns;
  for (std::size_t o = 0; o < between_neighbours_.size(); ++o)
    between_neighbours_[o] =
        std::min(between_neighbours_[o], noise_between_neighbours(problem_, o, columns));
  // The white part is what the priors leave, and they are weighed against it.
  for (int round = 0; round < kRounds; ++round) {
    const Ground here = ground({}, shapes_.empty() ? noise_grid(problem_.timeline) : shapes_);
    for (std::size_t o = 0; o < white_sd_.size(); ++o)
      white_sd_[o].value = std::max(here.white_sd(static_cast<Eigen::Index>(o)).value,
                                    kLeastWhite * between_neighbours_[o]);
  }
}

Result<void> Extension::reoptimise() {
  for (int round = 0; round < kRounds; ++round)
    for (std::size_t i = 0; i < named_.size(); ++i) {
      const Cause& cause = causes_[named_[i].cause];
      if (cause.scale == ParameterScale::none) continue;
      if (tick_ && !tick_()) return cancelled();
      const Ground here = ground(i, shapes_);
      auto values = named_[i].values;
      for (std::size_t k = 0; k < values.size(); ++k) {
        const auto again =
            refine(cause, values[k].parameter, instants_, gain_of(here, cause, values, k));
        values[k] = at_value(values[k], again.value);
      }
      if (auto ok = set_values(named_[i], std::move(values)); !ok) return ok;
    }
  for (auto& one : named_) DRIFTWISE_RETURN_IF_ERROR(leave_superfluous_values(one));
  return {};
}

// Two values that came to lie on one another are one.
Result<void> Extension::leave_superfluous_values(Named& named) {
  const auto index = static_cast<std::size_t>(&named - named_.data());
  while (named.values.size() > 1) {
    const Ground here = ground(index, shapes_);
    const double all = here.gain(named.learned, named.prior.typical).gain;
    std::size_t least = 0;
    double highest = -INFINITY;
    for (std::size_t k = 0; k < named.values.size(); ++k) {
      auto others = named.values;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
      const double gain = gain_of(here, causes_[named.cause], others, 0)(others[0].parameter);
      if (gain <= highest) continue;
      highest = gain;
      least = k;
    }
    if (all - highest >= kExplainedByOthers) return {};
    auto kept = named.values;
    kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(least));
    DRIFTWISE_RETURN_IF_ERROR(set_values(named, std::move(kept)));
  }
  return {};
}

std::optional<std::size_t> Extension::index_of(std::size_t cause) const {
  for (std::size_t i = 0; i < named_.size(); ++i)
    if (named_[i].cause == cause) return i;
  return std::nullopt;
}

Result<void> Extension::set_values(Named& named, std::vector<Cell> values) const {
  named.terms = terms_of(values);
  DRIFTWISE_TRY(auto columns, searched_columns(problem_, named.terms));
  named.values = std::move(values);
  named.all = std::move(columns);
  named.learned = problem_.learned(named.all);
  named.prior = physics_.prior(causes_[named.cause], named.terms, named.values.front().parameter,
                               named.learned);
  return {};
}

Result<void> Extension::add_value(std::size_t index, const Candidate& candidate) {
  auto values = named_[index].values;
  values.push_back({candidate.refined.value, candidate.terms});
  if (auto ok = set_values(named_[index], std::move(values)); !ok) return ok;
  return reoptimise();
}

void Extension::withdraw(std::size_t index) {
  named_.erase(named_.begin() + static_cast<std::ptrdiff_t>(index));
}

Result<void> Extension::withdraw_with_its_train(std::size_t index) {
  withdraw(index);
  for (auto& one : named_) DRIFTWISE_RETURN_IF_ERROR(leave_superfluous_values(one));
  return {};
}

Extension::Candidate Extension::as_it_stands(std::size_t index, const Standing& standing,
                                             const Ground& ground) const {
  const Named& named = named_[index];
  Candidate result{.cause = named.cause,
                   .refined = {named.values.front().parameter, 0},
                   .gain = ground.settled_gain(named.learned, named.prior.typical),
                   .terms = named.terms,
                   .prior = named.prior};
  result.refined.gain = result.gain.gain;
  result.evidence = result.gain.gain + standing.occam();
  result.beyond = result.evidence + standing.over_chance();
  return result;
}

std::vector<double> Extension::aliases_of(std::size_t index) const {
  constexpr double kLoose = 1e-3;  // of the range: places of a lattice that an axis comes to
  constexpr double kOpen = 6;      // in 2 ln L
  const Named& one = named_[index];
  const Cause& cause = causes_[one.cause];
  const auto* wave = std::get_if<effects::Call>(&one.terms.front().factors.front());
  if (cause.scale != ParameterScale::inverse || wave == nullptr) return {};
  const auto where =
      problem_.prepared.phase_values(wave->symbols.empty() ? std::string() : wave->symbols.front());
  std::vector<double> values(where.begin(), where.end());
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  if (values.empty()) return {};
  if (cause.parameter == "period_nm")
    for (double& value : values) value = nm_from_mm(value);
  const auto [low, high] = std::ranges::minmax(values);
  const double period = one.values.front().parameter;
  const Ground here = ground(index, shapes_);
  const auto gain = gain_of(here, cause, one.values, 0);
  const double least = gain(period) - kOpen;
  std::vector<double> found;
  for (const double other :
       alike_on_a_lattice(period, lattice_spacing(values, kLoose * (high - low)))) {
    const Refined at = refine(cause, other, instants_, gain);
    if (at.gain > least) found.push_back(at.value);
  }
  return found;
}

std::optional<Profile> Extension::profile_of(std::size_t index) const {
  const Named& one = named_[index];
  const Cause& cause = causes_[one.cause];
  if (cause.scale == ParameterScale::none) return std::nullopt;
  const Ground here = ground(index, shapes_);
  const auto gain = gain_of(here, cause, one.values, 0);
  const double value = one.values.front().parameter;
  return profile(cause, {value, gain(value)}, instants_, gain);
}

}  // namespace driftwise::diagnosis
