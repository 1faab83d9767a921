// The last look at what was named: each finding against all others, and which it cannot be told
// from.

#include <algorithm>
#include <cmath>
#include <set>

#include "server/core/try.h"
#include "server/diagnosis/answer/cancelled.h"
#include "server/diagnosis/catalogue/linear_parameter.h"
#include "server/diagnosis/growth/extension.h"
#include "server/diagnosis/rows/held_out_gain.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kRival = 6;  // in 2 ln L
constexpr double kTie = 2;    // in 2 ln of evidence: "not worth more than a bare mention" (Kass and
                              // Raftery, J. Am. Stat. Assoc. 90 (1995) 773)
constexpr double kRivalCorrelation = 0.95;  // of fitted contributions, whitened
constexpr double kFamilyCorrelation = 0.7;  // of a lag and a rate of one sensor in the baseline
constexpr double kNoticed = 14;             // nobody is a rival who would not be noticed alone
constexpr double kMisfit = 0.05;            // of the gain of the strongest
constexpr double kOwnWidth = 1;             // in 2 ln L: one standard error
constexpr double kSameWidth = 0.01;
constexpr int kOwnWidthRounds = 4;

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

// With its sensor in the simulation T - lag(T, tau) is tau times a rate: two names of one thing.
bool one_family(const Cause& a, const Cause& b) {
  const auto is = [](const Cause& cause) {
    return cause.id == "thermal_lag" || cause.id == "thermal_rate";
  };
  return is(a) && is(b) && a.id != b.id && a.subject == b.subject;
}

// Order of a cause's physics in the channels that it reads: 1 is linear. A law that is no
// polynomial (the contact of a ball) is above linear too.
int order_of(const std::vector<effects::Term>& terms) {
  int highest = 0;
  for (const auto& term : terms) {
    int order = 0;
    for (const auto& factor : term.factors) {
      const auto* power = std::get_if<effects::Power>(&factor);
      order += power != nullptr ? power->exponent : 2;
    }
    highest = std::max(highest, order);
  }
  return highest;
}

std::set<std::string> channels_of(const std::vector<effects::Term>& terms) {
  std::set<std::string> symbols;
  for (const auto& term : terms)
    for (const auto& symbol : effects::symbols_of(term)) symbols.insert(symbol);
  return symbols;
}

// 2 ln L by which the rows would tell two contributions from one another if one of them was there,
// at least: the part of either that is not along the other. noise: of each output.
double told_apart(const Gain& a, const Gain& b, const Ground& ground) {
  double sum = 0;
  for (std::size_t o = 0; o < a.contribution.size(); ++o) {
    const auto &u = a.contribution[o], &v = b.contribution[o];
    if (u.size() == 0 && v.size() == 0) continue;
    if (u.size() == 0 || v.size() == 0 || a.shape[o] != b.shape[o]) return INFINITY;
    const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v);
    if (uu == 0 && vv == 0) continue;
    if (!(uv > 0)) return INFINITY;
    const double noise = ground.white_sd_with(a, static_cast<Eigen::Index>(o)).value;
    sum += std::max(0.0, std::max(uu, vv) - uv * uv / std::min(uu, vv)) / (noise * noise);
  }
  return sum;
}

}  // namespace

// Who stands for one of the named when it is taken out: the best first.
std::optional<std::vector<Extension::Candidate>> Extension::stand_ins(std::size_t index) {
  auto allowed = this->allowed();
  const std::size_t own = named_[index].cause;
  allowed[own] = 1;
  const auto look = search_.compare(learned(index), allowed);
  if (!look) return std::nullopt;
  if (!look->first) return std::vector<Candidate>{};
  shapes_ = look->shapes;
  const Ground here = ground(index, shapes_);
  std::vector<std::size_t> present;
  for (std::size_t c = 0; c < causes_.size(); ++c)
    if (c == own || index_of(c) || one_family(causes_[c], causes_[own])) present.push_back(c);
  auto best = contenders(*look, here, present);
  if (named_[index].values.size() > 1)
    for (auto& one : best)
      if (one.cause == own) one = as_it_stands(index, look->causes[own], here);
  std::ranges::stable_sort(best, before);
  return best;
}

Result<std::vector<std::string>> Extension::settle() {
  std::vector<std::string> said;
  for (std::size_t i = 0; i < named_.size();) {
    const auto best = stand_ins(i);
    if (!best || (tick_ && !tick_())) return cancelled();
    const std::string name = name_of(causes_[named_[i].cause]);
    if (best->empty() || !best->front().nameable || best->front().beyond < kExplainedByOthers) {
      if (!best->empty())
        said.push_back(name + (best->front().beyond >= kExplainedByOthers
                                   ? " was named, and a geometry of higher order explains half of "
                                     "it or more: it has no name"
                               : named_.size() > 1
                                   ? " was named and is explained by what was found beside it"
                                   : " was named first; with the noise as it is without it, chance "
                                     "imitates it: it may be there"));
      withdraw(i);
      continue;
    }
    if (const auto family = value_of_another(i, *best)) {
      const std::size_t cause = (*best)[*family].cause;
      said.push_back(name + " was named and is what one value leaves of " +
                     name_of(causes_[cause]));
      withdraw(i);
      DRIFTWISE_RETURN_IF_ERROR(add_value(*index_of(cause), (*best)[*family]));
      i = 0;
      continue;
    }
    const std::size_t first = preferred(*best, ground(i, shapes_));
    const Candidate& chosen = (*best)[first];
    if (chosen.cause != named_[i].cause) {
      DRIFTWISE_TRY(auto one, made(chosen, named_[i].p_adjusted));
      said.push_back(name + " was named first; with the rest known, " +
                     name_of(causes_[one.cause]) + " explains more");
      named_[i] = std::move(one);
    } else if (named_[i].values.size() == 1) {
      DRIFTWISE_TRY(auto one, made(chosen, named_[i].p_adjusted));
      named_[i] = std::move(one);
    } else {
      named_[i].evidence = chosen.evidence;
      named_[i].likelihood = chosen.gain.likelihood;
      named_[i].share = chosen.gain.share;
    }
    name_rivals(i, *best, first);
    ++i;
  }
  update_noise();
  leave_misfits(said);
  DRIFTWISE_RETURN_IF_ERROR(place_instants());
  DRIFTWISE_RETURN_IF_ERROR(take_own_widths());
  return said;
}

// A play is as wide as the step that it leaves at a reversal, and that is how far a move has to go
// for it. Where all moves go farther the readings have the step alone, and any width of a grid
// would do for the other.
Result<void> Extension::take_own_widths() {
  for (std::size_t i = 0; i < named_.size(); ++i) {
    const Named& named = named_[i];
    const Cause& cause = causes_[named.cause];
    const bool of_angle = cause.linear == LinearParameter::width_arcsec;
    if ((cause.linear != LinearParameter::width_nm && !of_angle) || named.terms.size() != 1 ||
        named.terms.front().factors.size() > 1)
      continue;
    // A coordinate shows a part of a motor's step, by its slopes.
    if (is_motor_symbol(cause.subject) && !problem_.given_outputs.empty()) continue;
    const auto acts = std::ranges::max_element(named.share);
    const auto output = static_cast<std::size_t>(acts - named.share.begin());
    if (problem_.outputs[output].unit != (of_angle ? "arcsec" : "nm")) continue;
    if (tick_ && !tick_()) return cancelled();
    const Ground here = ground(i, shapes_);
    const auto gain = gain_of(here, cause, named.values, 0);
    const double least = gain(named.values.front().parameter) - kOwnWidth;
    for (int round = 0; round < kOwnWidthRounds; ++round) {
      const Cell now = named.values.front();
      const auto o = static_cast<Eigen::Index>(output);
      const double amplitude =
          here.amplitudes(named.learned, named.prior.typical, here.best_shape(o), o).mean[0];
      const auto number = of_angle
                              ? linear_number_of_angle(cause.linear, now.terms[0], now.parameter)
                              : linear_number(cause.linear, now.terms[0], now.parameter);
      const double width = std::abs(number.factor * amplitude);
      if (!(width > 0) || std::abs(width - now.parameter) < kSameWidth * width ||
          gain(width) < least)
        break;
      DRIFTWISE_RETURN_IF_ERROR(
          set_values(named_[i], {{width, with_parameter(now.terms, width), now.weight}}));
    }
  }
  return {};
}

// The rows that learn know a jump to be between two of them and no more. A held-out line of points
// in there would lie on the wrong side, all of it, at most places of the instant; so those rows say
// where it is, by least squares about what is predicted with the jump before them and after them.
// Whether there is a jump, and its height, stays with the rows that learn.
Result<void> Extension::place_instants() {
  for (std::size_t i = 0; i < named_.size(); ++i)
    if (causes_[named_[i].cause].scale == ParameterScale::instant)
      for (std::size_t v = 0; v < named_[i].values.size(); ++v)
        DRIFTWISE_RETURN_IF_ERROR(place_instant(i, v));
  return {};
}

Result<void> Extension::place_instant(std::size_t index, std::size_t value) {
  const auto& time_s = problem_.data().time_s;
  const double instant_s = named_[index].values[value].parameter;
  const auto after = std::ranges::find_if(problem_.learn,
                                          [&](std::size_t row) { return time_s[row] > instant_s; });
  if (after == problem_.learn.begin() || after == problem_.learn.end()) return {};
  const std::size_t first = *std::prev(after) + 1, last = *after;  // open: [first, last)
  if (first == last) return {};
  // costs: what a row adds where it lies before the jump less what it adds after it.
  std::vector<double> costs(last - first, 0);
  for (const bool jump_after : {true, false}) {
    const std::size_t edge = jump_after ? last : first;
    DRIFTWISE_RETURN_IF_ERROR(move_instant(index, value, (time_s[edge - 1] + time_s[edge]) / 2));
    for (std::size_t o = 0; o < problem_.outputs.size(); ++o) {
      const Eigen::VectorXd left = residuals(problem_, problem_.outputs[o], described(o));
      for (std::size_t row = first; row < last; ++row)
        if (const double r = left[static_cast<Eigen::Index>(row)] / between_neighbours_[o]; r == r)
          costs[row - first] += jump_after ? r * r : -r * r;
    }
  }
  double cost = 0, least = 0;
  std::size_t edge = first;
  for (std::size_t row = first; row < last; ++row)
    if ((cost += costs[row - first]) < least) {
      least = cost;
      edge = row + 1;
    }
  return move_instant(index, value, (time_s[edge - 1] + time_s[edge]) / 2);
}

Result<void> Extension::move_instant(std::size_t index, std::size_t value, double instant_s) {
  auto values = named_[index].values;
  Cell& moved = values[value];
  moved = {instant_s, with_parameter(moved.terms, instant_s), moved.weight};
  return set_values(named_[index], std::move(values));
}

// A time constant or a period is an idealisation: what it leaves of something strong is no cause.
Extension::Misfit Extension::misfit() const {
  std::optional<std::size_t> strongest;
  for (std::size_t i = 0; i < named_.size(); ++i)
    if (has_values(causes_[named_[i].cause]) &&
        (!strongest || named_[i].likelihood > named_[*strongest].likelihood))
      strongest = i;
  if (!strongest) return {};
  return {kMisfit * named_[*strongest].likelihood, name_of(causes_[named_[*strongest].cause])};
}

void Extension::leave_misfits(std::vector<std::string>& said) {
  const Misfit misfit = this->misfit();
  for (std::size_t i = named_.size(); i-- > 0;) {
    if (named_[i].likelihood >= misfit.likelihood) continue;
    said.push_back(name_of(causes_[named_[i].cause]) + " is not named: it explains less than " +
                   misfit.of + " may leave, whose real shape no one value describes exactly");
    withdraw(i);
  }
}

// The named cause that takes this one's place with another value of its parameter, if one does
// about as well.
std::optional<std::size_t> Extension::value_of_another(std::size_t index,
                                                       const std::vector<Candidate>& best) const {
  for (std::size_t k = 0; k < best.size(); ++k)
    if (const auto at = index_of(best[k].cause);
        at && *at != index && comes_near(best[k], best.front()))
      return k;
  return std::nullopt;
}

// Evidence of a cause over all of its subjects, as 2 ln of the ratio to the best candidate. The
// subject, one of ten thermometers, is searched as a parameter is, with equal odds: the best of ten
// alike gains nothing by their number.
double Extension::wherever_it_acts(const std::string& id,
                                   const std::vector<Candidate>& best) const {
  const auto places = std::ranges::count(causes_, id, &Cause::id);
  double sum = 0;
  for (const auto& one : best)
    if (causes_[one.cause].id == id) sum += std::exp((one.evidence - best.front().evidence) / 2);
  return 2 * std::log(sum / static_cast<double>(std::max<std::ptrdiff_t>(places, 1)));
}

// An instrument's air, or its drift, that the evidence does not tell from the robot's cause is the
// safer name: what is said of the robot is served, and the set has both. A drift is what nothing
// sensed explains, so the air comes before it.
std::size_t Extension::preferred(const std::vector<Candidate>& best, const Ground& ground) const {
  const auto close = [&](const Candidate& one) {
    return one.nameable && one.gain.likelihood > best.front().gain.likelihood - kRival &&
           one.evidence > best.front().evidence - kWithinReach;
  };
  const double of_the_best = wherever_it_acts(causes_[best.front().cause].id, best);
  for (const char* safer : {"refractive_index", "instrument_drift"})
    for (std::size_t k = 0; k < best.size(); ++k)
      if (causes_[best[k].cause].id == safer && close(best[k]) &&
          wherever_it_acts(safer, best) > of_the_best - kTie)
        return k;
  // Nor is a cause named for what a simpler one does with some of its terms.
  for (std::size_t k = 1; k < best.size(); ++k)
    if (close(best[k]) && best[k].terms.size() < best.front().terms.size() &&
        std::ranges::all_of(best[k].terms, [&](const effects::Term& term) {
          return std::ranges::find(best.front().terms, term) != best.front().terms.end();
        }))
      return k;
  // Nor for a law of higher order where these rows have one column for it and for the linear one:
  // of a load that is on or off F, F^2 and F^(2/3) are the same, and the width of a prior alone
  // would choose the name. What is served between the levels differs.
  std::size_t simplest = 0;
  for (std::size_t k = 1; k < best.size(); ++k)
    if (close(best[k]) && causes_[best[k].cause].scale == ParameterScale::none &&
        causes_[best.front().cause].scale == ParameterScale::none &&
        channels_of(best[k].terms) == channels_of(best.front().terms) &&
        order_of(best[k].terms) < order_of(best[simplest].terms) &&
        told_apart(best[k].gain, best.front().gain, ground) < kTie)
      simplest = k;
  return simplest;
}

void Extension::name_rivals(std::size_t index, const std::vector<Candidate>& best,
                            std::size_t first) {
  Named& one = named_[index];
  one.rivals.clear();
  for (std::size_t k = 0; k < best.size(); ++k) {
    if (k == first || index_of(best[k].cause)) continue;
    const double alike = correlation(best[k].gain, best[first].gain);
    const bool noticed = best[k].beyond > kNoticed;
    const bool family = one_family(causes_[best[k].cause], causes_[one.cause]);
    // By the likelihood within three prior widths, less what the search over the parameter bought:
    // an assumed width alone decides nothing.
    const double searched =
        best[first].evidence - best[first].gain.gain - (best[k].evidence - best[k].gain.gain);
    const bool near = best[k].gain.likelihood - best[first].gain.likelihood > searched - kRival &&
                      best[k].evidence > best[first].evidence - kWithinReach;
    if (near || (noticed && alike > kRivalCorrelation) ||
        (family && (noticed || alike > kFamilyCorrelation)))
      one.rivals.push_back(best[k].cause);
  }
}

}  // namespace driftwise::diagnosis
