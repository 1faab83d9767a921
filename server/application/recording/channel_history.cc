#include "server/application/recording/channel_history.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "server/core/reasons.h"

namespace driftwise::application {

void ChannelHistory::add(const Reading& reading, std::span<const RejectedValue> rejected) {
  const auto at = reading.middle();
  began_[reading.device] = reading.start;
  for (const auto& value : reading.values) {
    auto [entry, is_new] = tracks_.try_emplace(value.channel);
    auto& track = entry->second;
    if (is_new) {
      order_.push_back(value.channel);
      track.latest.channel = value.channel;
    }
    track.latest.device = reading.device;
    if (is_missing(value.value) ||
        std::ranges::find(rejected, value.channel, &RejectedValue::channel) != rejected.end())
      continue;
    // Two devices' clocks never mix within a channel, but a device whose clock was set back must
    // not break the order.
    auto place = track.samples.end();
    while (place != track.samples.begin() && std::prev(place)->at > at) --place;
    track.samples.insert(place, {at, reading.start, value.value});
    if (track.samples.size() > kept_) track.samples.pop_front();
    track.latest.value = value.value;
    track.latest.at = at;
  }
}

Result<Joined> ChannelHistory::at(const std::string& channel, CellTime instant, double max_age_s,
                                  CellTime since) const {
  const auto found = tracks_.find(channel);
  if (found == tracks_.end() || found->second.samples.empty())
    return fail(ErrorCode::failed_precondition, reasons::kChannelMissing,
                fmt::format("{} gave no value yet: look at its device and probe", channel));
  const auto& samples = found->second.samples;
  const auto first = std::ranges::find_if(
      samples, [since](CellTime began) { return began >= since; }, &Sample::began);
  const auto after =
      std::ranges::lower_bound(first, samples.end(), instant, std::less(), &Sample::at);
  const bool has_after = after != samples.end();
  const bool has_before = after != first;
  const double to_after_s = has_after ? seconds_from(after->at - instant) : INFINITY;
  const double to_before_s = has_before ? seconds_from(instant - std::prev(after)->at) : INFINITY;
  const double nearest_s = std::min(to_after_s, to_before_s);
  if (nearest_s > max_age_s)
    return fail(ErrorCode::failed_precondition, reasons::kChannelTooOld,
                fmt::format("{} too old: {:.0f} s, limit {:g} s", channel, nearest_s, max_age_s));
  if (to_before_s <= max_age_s && to_after_s <= max_age_s) {
    const double gap_s = to_before_s + to_after_s;
    const double weight = gap_s > 0 ? to_before_s / gap_s : 0;
    const double before = std::prev(after)->value;
    return Joined{before + weight * (after->value - before), nearest_s};
  }
  return Joined{to_after_s < to_before_s ? after->value : std::prev(after)->value, nearest_s};
}

bool ChannelHistory::has_reading_since(const std::string& device, CellTime since) const {
  const auto found = began_.find(device);
  return found != began_.end() && found->second >= since;
}

std::vector<ChannelHistory::Latest> ChannelHistory::latest() const {
  std::vector<Latest> all;
  for (const auto& name : order_) all.push_back(tracks_.at(name).latest);
  return all;
}

const ChannelHistory::Latest* ChannelHistory::latest(const std::string& channel) const {
  const auto found = tracks_.find(channel);
  return found == tracks_.end() ? nullptr : &found->second.latest;
}

}  // namespace driftwise::application
