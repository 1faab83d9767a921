#include "server/application/alarms/channel_alarms.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/core/data/reading.h"

namespace driftwise::application {
namespace {

AlarmLevel level_of(AlarmPriority priority) {
  switch (priority) {
    case AlarmPriority::low:
      return AlarmLevel::notice;
    case AlarmPriority::medium:
      return AlarmLevel::warning;
    case AlarmPriority::high:
    case AlarmPriority::critical:
      return AlarmLevel::failed;
  }
  return AlarmLevel::warning;
}

// Distance of the value beyond the limit, in the channel's unit.
double excess(const ChannelAlarmDescription& rule, double value) {
  return rule.above ? value - *rule.above : *rule.below - value;
}

std::string limit_text(const ChannelAlarmDescription& rule) {
  return rule.above ? fmt::format("above {:g}", *rule.above)
                    : fmt::format("below {:g}", rule.below.value_or(0));
}

std::string_view kind_of(const ChannelAlarmDescription& rule) {
  return alarm_priority_from(rule.priority) == AlarmPriority::critical ? kCriticalChannelLimit
                                                                       : kChannelLimit;
}

std::string subject_of(const ChannelAlarmDescription& rule) {
  return fmt::format("{} {}", rule.channel, limit_text(rule));
}

}  // namespace

ChannelAlarms::ChannelAlarms(std::vector<ChannelAlarmDescription> limits) {
  for (auto& rule : limits) limits_.emplace_back().rule = std::move(rule);
}

void ChannelAlarms::take(const std::string& channel, const std::string& device, double value,
                         CellTime now) {
  if (is_missing(value)) return;
  for (auto& limit : limits_) {
    if (limit.rule.channel != channel) continue;
    limit.is_read = true;
    limit.value = value;
    limit.device = device;
    const double beyond = excess(limit.rule, value);
    if (beyond > 0) {
      if (!limit.beyond_since) limit.beyond_since = now;
      limit.stands = limit.stands || seconds_from(now - *limit.beyond_since) >= limit.rule.for_s;
    } else {
      limit.beyond_since.reset();
      limit.stands = limit.stands && beyond > -limit.rule.hysteresis;
    }
  }
}

void ChannelAlarms::stand(const std::string& kind, const std::string& subject) {
  for (auto& limit : limits_)
    if (kind_of(limit.rule) == kind && subject_of(limit.rule) == subject) limit.stands = true;
}

bool ChannelAlarms::has_judged(const std::string& kind, const std::string& subject) const {
  return std::ranges::all_of(limits_, [&](const Limit& limit) {
    return limit.is_read || kind_of(limit.rule) != kind || subject_of(limit.rule) != subject;
  });
}

std::vector<AlarmCondition> ChannelAlarms::conditions(CellTime now) const {
  std::vector<AlarmCondition> out;
  for (const auto& limit : limits_) {
    const auto& rule = limit.rule;
    const bool lasted = limit.beyond_since && seconds_from(now - *limit.beyond_since) >= rule.for_s;
    if (!limit.is_read || (!limit.stands && !lasted)) continue;
    const auto priority = alarm_priority_from(rule.priority).value_or(AlarmPriority::medium);
    const std::string of = limit_text(rule);
    out.push_back(
        {.level = level_of(priority),
         .kind = std::string(kind_of(rule)),
         .subject = subject_of(rule),
         .message = fmt::format(
             "{} is {:.6g}: a limit of this cell file is {}{}{}", rule.channel, limit.value, of,
             rule.hysteresis > 0 ? fmt::format(", over when it is {:g} back", rule.hysteresis)
                                 : std::string(),
             rule.sentence.empty() ? "" : ". " + rule.sentence),
         .device = limit.device});
  }
  return out;
}

}  // namespace driftwise::application
