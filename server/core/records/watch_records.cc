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

}  // namespace driftwise
