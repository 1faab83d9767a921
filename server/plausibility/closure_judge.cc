#include "server/plausibility/closure_judge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace driftwise::plausibility {
namespace {

constexpr double kOtherForce_n = 0.02;  // the nearest of an actuator's own weights
constexpr double kNmPerUm = 1e3;
constexpr double kOtherForceTurns = 10;  // limits of rotation under another force

double at(const std::vector<double>& values, std::size_t i) {
  return i < values.size() && !is_missing(values[i]) ? values[i] : 0.0;
}

double limit_of(const ClosureRules& rules, const std::string& channel, double usual) {
  const auto& limits = rules.limits;
  const auto found = std::ranges::find(limits, channel, &ClosureLimitDescription::channel);
  return found == limits.end() ? usual : found->limit;
}

double noise_of(const CellDescription& cell, const std::string& channel) {
  for (const auto& device : cell.devices) {
    if (const auto* length = device.length(); length && length->channel.name() == channel)
      return length->u_length_nm;
    for (const auto& angle : device.angles())
      if (angle.channel.name() == channel) return angle.u_arcsec;
  }
  return 0;
}

std::vector<double> keep_missing(std::vector<double> now, const std::vector<double>& before) {
  for (std::size_t i = 0; i < now.size(); ++i)
    if (is_missing(now[i])) now[i] = at(before, i);
  return now;
}

bool is_angle(const ClosureCoordinate& one) { return one.channel.ends_with("_arcsec"); }

std::string sentence_of(const ClosureCoordinate& one, const ExpectedClosure& expected) {
  const bool angle = is_angle(one);
  auto text = angle
                  ? fmt::format("{} turned by {:+.2f} arcsec (limit {:g})",
                                one.channel.substr(0, one.channel.find('_')), one.found, one.limit)
                  : fmt::format("{} moved by {:+.0f} nm (limit {:.0f})",
                                one.channel.substr(0, one.channel.find('_')), one.found, one.limit);
  const double share = angle ? 100 * one.expected : one.expected;
  if (!expected.by.empty() && std::abs(share) >= 0.5)
    text += angle ? fmt::format(", of which {:+.2f} arcsec is expected from {:+.2f} K by {}",
                                one.expected, expected.warming_k, expected.by)
                  : fmt::format(", of which {:+.0f} nm is expected from {:+.2f} K by {}",
                                one.expected, expected.warming_k, expected.by);
  return text;
}

}  // namespace

void ClosureJudge::begin(CellTime at, std::optional<double> force_n, std::string side) {
  begin(Closure{at, {}, {}, force_n, std::move(side)});
}

void ClosureJudge::begin(Closure zero) {
  newest_ = std::move(zero);
  zero_side_ = newest_.side;
  of_side_.clear();
  of_side_[newest_.side] = newest_;
}

const ClosureJudge::Base* ClosureJudge::base_of(const std::string& side) const {
  const auto found = plays_.find(side);
  return found == plays_.end() ? nullptr : &found->second;
}

const Closure& ClosureJudge::reference(const Closure& closure) const {
  const auto found = of_side_.find(closure.side);
  return found == of_side_.end() ? newest_ : found->second;
}

ClosureVerdict ClosureJudge::judge(const Closure& closure, const ExpectedClosure& expected) {
  const auto& rules = cell_.plausibility;
  const auto& before = reference(closure);
  const auto *here = base_of(closure.side), *there = base_of(before.side);
  const bool same_side = before.side == closure.side;
  const bool known_play = !same_side && here != nullptr && there != nullptr;
  const double minutes = std::max(0.0, seconds_from(closure.at - before.at)) / 60;
  const double per_min = rules.closure_nm_per_min.value_or(cell_.checks.max_drift_nm_per_min);
  // Another force bends the robot: then only what the declared geometry allows is a limit.
  const bool same_force =
      std::abs(closure.force_n.value_or(0) - before.force_n.value_or(0)) <= kOtherForce_n;
  ClosureVerdict verdict;
  verdict.other_side = !same_side && !known_play;
  const auto add = [&](const std::string& channel, std::size_t place, double found, double limit,
                       double expects, double sd) {
    ClosureCoordinate one{channel, found, limit, expects, sd, noise_of(cell_, channel), 0};
    if (known_play) one.play = at(*here, place) - at(*there, place);
    one.found -= one.play;
    const bool within = std::abs(one.found) <= limit;
    const bool explained = !expected.by.empty() && std::abs(one.unexplained()) <= limit;
    if (!within) {
      verdict.good = verdict.good && explained;
      verdict.explained = true;
      verdict.sentence += (verdict.sentence.empty() ? "" : ", ") + sentence_of(one, expected);
    }
    verdict.coordinates.push_back(std::move(one));
  };
  const auto lengths = cell_.length_channels();
  const auto angles = cell_.angle_channels();
  for (std::size_t i = 0; i < std::min(lengths.size(), closure.lengths_nm.size()); ++i) {
    if (is_missing(closure.lengths_nm[i])) continue;
    const auto name = lengths[i].name();
    const double limit_nm = limit_of(rules_, name, rules.closure_nm) + per_min * minutes +
                            (same_force ? 0 : kNmPerUm * rules.geometry_um);
    add(name, i, closure.lengths_nm[i] - at(before.lengths_nm, i), limit_nm,
        at(expected.lengths_nm, i), at(expected.lengths_sd_nm, i));
  }
  for (std::size_t i = 0; i < std::min(angles.size(), closure.angles_arcsec.size()); ++i) {
    if (is_missing(closure.angles_arcsec[i])) continue;
    const auto name = angles[i].name();
    const double limit_arcsec =
        limit_of(rules_, name, rules.closure_arcsec) * (same_force ? 1 : kOtherForceTurns);
    add(name, lengths.size() + i, closure.angles_arcsec[i] - at(before.angles_arcsec, i),
        limit_arcsec, at(expected.angles_arcsec, i), 0);
  }
  verdict.explained = verdict.explained && verdict.good;
  if (verdict.good) take(closure);
  return verdict;
}

double ClosureJudge::play(const std::string& side, std::size_t length) const {
  const auto *here = base_of(side), *there = base_of(zero_side_);
  return here != nullptr && there != nullptr ? at(*here, length) - at(*there, length) : 0;
}

void ClosureJudge::take(const Closure& closure) {
  const auto before = reference(closure);
  newest_ = closure;
  newest_.lengths_nm = keep_missing(closure.lengths_nm, before.lengths_nm);
  newest_.angles_arcsec = keep_missing(closure.angles_arcsec, before.angles_arcsec);
  of_side_[closure.side] = newest_;
}

void ClosureJudge::take_play(const Closure& here, const Closure& there) {
  const auto joined = [](const Closure& closure) {
    auto all = closure.lengths_nm;
    all.insert(all.end(), closure.angles_arcsec.begin(), closure.angles_arcsec.end());
    return all;
  };
  const auto now = joined(here), against = joined(there);
  auto& base = plays_[there.side];
  base.resize(now.size());
  Base mine(now.size());
  for (std::size_t i = 0; i < now.size(); ++i) mine[i] = base[i] + at(now, i) - at(against, i);
  plays_[here.side] = std::move(mine);
  // The zero counts as from the side that it was found again from.
  if (zero_side_.find('?') != std::string::npos) zero_side_ = there.side;
}

}  // namespace driftwise::plausibility
