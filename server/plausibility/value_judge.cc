#include "server/plausibility/value_judge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/core/devices/role_settings.h"

namespace driftwise::plausibility {
namespace {

// Drift that all probes of a scanner may show together between two scans.
constexpr double kTogether_k_per_s = 0.001;
constexpr std::size_t kFewestProbes = 3;
// Share of the possible step that counts as a step while a channel is in doubt.
constexpr double kStepBack = 0.5;

double seconds_between(CellTime from, CellTime to) {
  return std::max(0.0, seconds_from(to - from));
}

}  // namespace

int frozen_limit(const ChannelLimit& limit, const EqualAnswers& before) {
  if (limit.frozen_answers >= 0) return limit.frozen_answers;
  if (before.reversals < kReversalsToKnow) return 0;
  // Share of the answers that repeated the one before, by Laplace's rule of succession.
  const double answers = static_cast<double>(before.answers);
  const double repeats = std::clamp((answers - before.changes + 1) / (answers + 2), 0.0, 0.999);
  const double by_chance = std::ceil(std::log(kByChance) / std::log(std::max(repeats, 1e-6)));
  return std::max({kFewestEqual, 3 * before.longest + 2, static_cast<int>(by_chance)});
}

ValueJudge::Track& ValueJudge::track_of(const DeviceDescription& device,
                                        const std::string& channel) {
  const auto [found, is_new] = tracks_.try_emplace({device.id, channel});
  if (is_new) found->second.limit = limit_of(cell_, device, channel);
  return found->second;
}

std::vector<Finding> ValueJudge::judge(JudgedReading& reading) {
  std::vector<Finding> findings;
  const auto* device = cell_.find_device(reading.device);
  if (device == nullptr) return findings;
  reading.rejected.clear();
  const auto reject = [&reading](const std::string& channel, const Finding& finding) {
    reading.rejected.push_back({channel, finding.test, finding.reason});
  };
  // Before the values themselves are taken over as the last ones.
  if (auto whole = judge_together(*device, reading)) {
    for (const auto& probe : device->probes())
      if (reading.find(probe.channel.name()) != nullptr) reject(probe.channel.name(), *whole);
    findings.push_back(std::move(*whole));
  }
  for (const auto& value : reading.values) {
    auto found =
        judge_value(reading.device, value, track_of(*device, value.channel), reading.middle());
    if (!found || reading.is_rejected(value.channel)) continue;
    reject(value.channel, *found);
    findings.push_back(std::move(*found));
  }
  for (auto& finding : findings) finding.device = reading.device;
  return findings;
}

std::optional<Finding> ValueJudge::judge_value(const std::string& device, const ChannelValue& value,
                                               Track& track, CellTime at) const {
  const auto& limit = track.limit;
  const auto found = [&](const char* test, std::string reason) {
    return Finding{{}, value.channel, test, std::move(reason), at};
  };
  if (is_missing(value.value)) {
    if (limit.missing == Missing::allowed) return std::nullopt;
    return found("missing", value.channel + " has no value: look at its probe and wire");
  }
  if (!std::isfinite(value.value))
    return found("not_finite",
                 fmt::format("{} is {}, which is no number", value.channel, value.value));
  if (value.value < limit.min || value.value > limit.max)
    return found("range", fmt::format("{} is {:g}, possible is {:g} to {:g} ({})", value.channel,
                                      value.value, limit.min, limit.max, limit.source));
  auto stepped = judge_step(track, value, at);
  auto frozen = judge_equal(device, value, track, at);
  // What it says when it is thawed may be as far away as the time since it froze allows.
  if (frozen && track.equal) track.last = track.equal;
  return stepped ? stepped : frozen;
}

std::optional<Finding> ValueJudge::judge_step(Track& track, const ChannelValue& value,
                                              CellTime at) const {
  const auto& limit = track.limit;
  const auto last = std::exchange(track.last, Value{value.value, at});
  const double change = last ? value.value - last->value : 0;
  const double passed_s = last ? seconds_between(last->at, at) : 0;
  const double allowed = limit.max_step + limit.max_per_s * passed_s;
  // A step back may be a little smaller than the step was.
  const double share = track.stepped_by == 0 ? 1 : kStepBack;
  if (std::abs(change) > share * allowed) track.stepped_by += change;
  if (!limit.latches) {
    if (std::abs(change) <= allowed) return std::nullopt;
    track.stepped_by = 0;
    return Finding{{},
                   value.channel,
                   "step",
                   fmt::format("{} changed by {:+.4g} within {:.3g} s, possible is {:.3g}",
                               value.channel, change, passed_s, allowed),
                   at};
  }
  if (std::abs(track.stepped_by) <= limit.max_step) {
    track.stepped_by = 0;
    return std::nullopt;
  }
  return Finding{{},
                 value.channel,
                 "step",
                 fmt::format("{} stepped by {:+.4g} and has not stepped back, possible is a step "
                             "of {:g}; it joins no point until it is back or a person resumes the "
                             "run",
                             value.channel, track.stepped_by, limit.max_step),
                 at};
}

std::optional<Finding> ValueJudge::judge_equal(const std::string& device, const ChannelValue& value,
                                               Track& track, CellTime at) const {
  const int limit = frozen_limit(
      track.limit, {track.longest_equal, track.reversals, track.changes, track.answers});
  if (track.equal && track.equal->value == value.value) {
    ++track.equal_count;
  } else {
    if (track.equal) end_row(track, value.value - track.equal->value);
    track.equal = Value{value.value, at};
    track.equal_count = 1;
    track.moved_count = 0;
    if (is_coarse(track)) track.others_then = others_of({device, value.channel}, track.limit);
  }
  if (limit == 0 || track.equal_count < limit) return std::nullopt;
  if (is_coarse(track)) {
    if (!others_have_moved(track)) return std::nullopt;
    // It follows its set point with a lag, however long it stood before.
    if (++track.moved_count < limit && track.limit.is_held) return std::nullopt;
  }
  track.is_frozen = true;
  return Finding{{},
                 value.channel,
                 "frozen",
                 fmt::format("{} is {:.9g} for {} answers in a row, its own noise allows {}",
                             value.channel, value.value, track.equal_count, limit - 1),
                 track.equal->at};
}

void ValueJudge::end_row(Track& track, double change) const {
  const int direction = change > 0 ? 1 : -1;
  const bool goes_back = track.direction != 0 && direction != track.direction;
  track.direction = direction;
  track.reversals += goes_back;
  track.finest_step = std::min(track.finest_step, std::abs(change));
  const bool is_single = std::abs(change) < 1.5 * track.finest_step;
  const bool of_ramp = !goes_back && !is_single;
  // A row that was judged as frozen is no example of what the channel does by itself.
  if (std::exchange(track.is_frozen, false)) return;
  track.longest_equal = std::max(track.longest_equal, track.equal_count);
  if (of_ramp) return;
  ++track.changes;
  track.answers += track.equal_count;
  track.single_steps += is_single;
}

bool ValueJudge::is_coarse(const Track& track) const {
  if (track.limit.frozen_answers >= 0) return false;
  if (track.answers > kCoarseAnswers * track.changes) return true;
  return static_cast<double>(track.answers) > kRepeats * track.changes &&
         track.single_steps >= kSingleSteps * track.changes;
}

ValueJudge::Others ValueJudge::others_of(const DeviceChannel& channel,
                                         const ChannelLimit& limit) const {
  const auto unit_of = [](const std::string& name) { return name.substr(name.rfind('_') + 1); };
  Others others;
  for (const auto& [of, track] : tracks_) {
    if (of == channel || !track.last || unit_of(of.second) != unit_of(channel.second)) continue;
    if (limit.is_held && of.first != channel.first) continue;
    others.emplace(of, track.last->value);
  }
  return others;
}

bool ValueJudge::others_have_moved(const Track& track) const {
  return std::ranges::any_of(track.others_then, [&](const auto& then) {
    const auto now = tracks_.find(then.first);
    return now != tracks_.end() && now->second.last &&
           std::abs(now->second.last->value - then.second) >= kStepsOfOthers * track.finest_step;
  });
}

std::optional<Finding> ValueJudge::judge_together(const DeviceDescription& device,
                                                  const Reading& reading) {
  if (device.probes().size() < kFewestProbes) return std::nullopt;
  double smallest_k = std::numeric_limits<double>::max(), passed_s = 0;
  int rising = 0;
  for (const auto& probe : device.probes()) {
    const double* value = reading.find(probe.channel.name());
    const auto& track = track_of(device, probe.channel.name());
    if (value == nullptr || !std::isfinite(*value) || !track.last) {
      smallest_k = 0;
      continue;
    }
    const double change = *value - track.last->value;
    rising += change > 0 ? 1 : -1;
    smallest_k = std::min(smallest_k, std::abs(change));
    passed_s = seconds_between(track.last->at, reading.middle());
  }
  auto& whole = scanners_[device.id];
  const double limit_k = cell_.plausibility.together_k;
  const bool one_way = static_cast<std::size_t>(std::abs(rising)) == device.probes().size();
  if (one_way && smallest_k > limit_k + kTogether_k_per_s * passed_s)
    whole.stepped_by_k += rising > 0 ? smallest_k : -smallest_k;
  if (std::abs(whole.stepped_by_k) <= limit_k) {
    whole.stepped_by_k = 0;
    return std::nullopt;
  }
  return Finding{
      {},
      device.probes().front().channel.name(),
      "together",
      fmt::format("all {} probes of {} stepped together by {:+.3f} K at least and have not stepped "
                  "back, no room does more than {:g} K ([plausibility] together_k): look at the "
                  "scanner; they join no point until they are back or a person resumes the run",
                  device.probes().size(), device.id, whole.stepped_by_k, limit_k),
      reading.middle()};
}

void ValueJudge::begin_anew(const std::string& device) {
  const auto* known = cell_.find_device(device);
  if (known == nullptr) return;
  const auto given = channels_of_settings(*known);
  for (auto& [key, track] : tracks_) {
    const auto is_it = [&key](const Channel& one) { return one.name() == key.second; };
    if (key.first != device || std::ranges::none_of(given, is_it)) continue;
    track.last.reset();
    track.stepped_by = 0;
  }
  scanners_.erase(device);
}

void ValueJudge::begin_anew() {
  for (auto& [key, track] : tracks_) {
    track.last.reset();
    track.stepped_by = 0;
  }
  scanners_.clear();
}

}  // namespace driftwise::plausibility
