#include "server/application/notify/news_rules.h"

#include <algorithm>
#include <ctime>

namespace driftwise::application {
namespace {

constexpr std::string_view kNotifyFailed = "notify.failed";

// It happened and was over at once.
bool is_momentary(const AlarmRecord& alarm) {
  return alarm.cleared.utc_ns != 0 && alarm.cleared == alarm.since;
}

bool is_over(const AlarmRecord& alarm) {
  return is_momentary(alarm) ? alarm.acknowledged.utc_ns != 0 : alarm.cleared.utc_ns != 0;
}

CellTime end_of(const AlarmRecord& alarm) {
  return is_momentary(alarm) ? alarm.acknowledged : alarm.cleared;
}

bool matches(const std::string& pattern, const std::string& kind) {
  if (!pattern.ends_with('*')) return pattern == kind;
  return kind.starts_with(std::string_view(pattern).substr(0, pattern.size() - 1));
}

}  // namespace

LocalTime local_time(UtcTime utc) {
  const std::time_t seconds = utc.ns / 1'000'000'000;
  std::tm parts{};
  localtime_r(&seconds, &parts);
  return {(parts.tm_wday + 6) % 7, parts.tm_hour * 60 + parts.tm_min};
}

bool in_hours(const ReceiverDescription& receiver, LocalTime at) {
  const auto on = [&receiver](int weekday) {
    return (receiver.days >> static_cast<unsigned>((weekday + 7) % 7) & 1U) != 0;
  };
  const int from = receiver.from_minute, to = receiver.to_minute;
  if (from == to) return on(at.weekday);
  if (from < to) return on(at.weekday) && at.minute >= from && at.minute < to;
  return (at.minute >= from && on(at.weekday)) || (at.minute < to && on(at.weekday - 1));
}

bool is_routed(const ReceiverDescription& receiver, const AlarmRecord& alarm) {
  if (alarm.kind == kNotifyFailed && alarm.subject == receiver.name) return false;
  const std::string level(to_string(alarm.level));
  if (!receiver.levels.empty() &&
      std::ranges::find(receiver.levels, level) == receiver.levels.end())
    return false;
  return receiver.kinds.empty() || std::ranges::any_of(receiver.kinds, [&](const auto& pattern) {
           return matches(pattern, alarm.kind);
         });
}

std::optional<DueNews> due_news(const NewsQuestion& question) {
  const auto& [receiver, alarm, told, known_since, open, open_then, now] = question;
  if (!open || is_finished(question)) return std::nullopt;
  if (told == nullptr || told->firing.utc_ns == 0) {
    if (alarm.shelved_until.utc_ns != 0) return std::nullopt;
    return DueNews{NewsKind::firing, alarm.since + nanoseconds_from_s(receiver.group_s)};
  }
  if (is_over(alarm)) return DueNews{NewsKind::resolved, end_of(alarm)};
  if (alarm.acknowledged.utc_ns != 0 || alarm.shelved_until.utc_ns != 0 || receiver.repeat_h <= 0)
    return std::nullopt;
  return DueNews{NewsKind::repeat, told->last + nanoseconds_from_s(receiver.repeat_h * 3600)};
}

bool is_finished(const NewsQuestion& question) {
  const auto& [receiver, alarm, told, known_since, open, open_then, now] = question;
  if (!is_routed(receiver, alarm)) return true;
  const bool is_cleared = alarm.cleared.utc_ns != 0;
  if (is_cleared && alarm.cleared < now - nanoseconds_from_s(kForget_s)) return true;
  if (told != nullptr && told->firing.utc_ns != 0)
    return is_over(alarm) && (!receiver.resolved || told->resolved.utc_ns != 0);
  if (is_cleared && (alarm.cleared < known_since || alarm.acknowledged.utc_ns != 0)) return true;
  // Somebody has seen it while this receiver was not to be disturbed.
  return !open_then && alarm.acknowledged.utc_ns != 0;
}

}  // namespace driftwise::application
