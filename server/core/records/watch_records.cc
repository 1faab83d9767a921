#include "server/core/records/watch_records.h"

namespace driftwise {

std::string_view to_string(AlarmLevel level) {
  switch (level) {
    case AlarmLevel::notice:
      return "notice";
    case AlarmLevel::warning:
      return "warning";
    case AlarmLevel::failed:
      return "failed";
  }
  return "notice";
}

std::optional<AlarmLevel> alarm_level_from(std::string_view text) {
  for (const AlarmLevel level : {AlarmLevel::notice, AlarmLevel::warning, AlarmLevel::failed})
    if (to_string(level) == text) return level;
  return std::nullopt;
}

std::string_view to_string(AlarmPriority priority) {
  switch (priority) {
    case AlarmPriority::low:
      return "low";
    case AlarmPriority::medium:
      return "medium";
    case AlarmPriority::high:
      return "high";
    case AlarmPriority::critical:
      return "critical";
  }
  return "medium";
}

std::optional<AlarmPriority> alarm_priority_from(std::string_view text) {
  for (const AlarmPriority priority :
       {AlarmPriority::low, AlarmPriority::medium, AlarmPriority::high, AlarmPriority::critical})
    if (to_string(priority) == text) return priority;
  return std::nullopt;
}

AlarmPriority priority_of(AlarmLevel level, std::string_view kind) {
  for (const std::string_view critical :
       {kCriticalChannelLimit, std::string_view("motion.uncommanded"),
        std::string_view("stop.unconfirmed"), std::string_view("run.moves_soon")})
    if (kind == critical) return AlarmPriority::critical;
  switch (level) {
    case AlarmLevel::notice:
      return AlarmPriority::low;
    case AlarmLevel::warning:
      return AlarmPriority::medium;
    case AlarmLevel::failed:
      return AlarmPriority::high;
  }
  return AlarmPriority::medium;
}

std::string_view to_string(AlarmState state) {
  switch (state) {
    case AlarmState::unacknowledged:
      return "unacknowledged";
    case AlarmState::acknowledged:
      return "acknowledged";
    case AlarmState::returned_unacknowledged:
      return "returned, unacknowledged";
    case AlarmState::normal:
      return "normal";
    case AlarmState::shelved:
      return "shelved";
  }
  return "unacknowledged";
}

AlarmState AlarmRecord::state() const {
  if (shelved_until.utc_ns != 0) return AlarmState::shelved;
  const bool seen = acknowledged.utc_ns != 0;
  if (cleared.utc_ns == 0) return seen ? AlarmState::acknowledged : AlarmState::unacknowledged;
  return seen ? AlarmState::normal : AlarmState::returned_unacknowledged;
}

}  // namespace driftwise
