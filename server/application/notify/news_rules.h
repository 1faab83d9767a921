#pragma once
// News that one receiver is due of one alarm, and when. Pure; the caller states the time.
//
// Nothing of an alarm that has been over for kForget_s; nothing of one that is over and that
// somebody has seen before this receiver was told that it began. First the alarm, group_s after its
// beginning, so that what begins together goes together; again every repeat_h until somebody
// acknowledges it; its end, where the receiver wants that. One that is over at its beginning
// (run.failed) ends when it is acknowledged. Outside its hours a receiver is told nothing; what
// stands or is unacknowledged when they begin is told then. A shelved alarm waits for the end of
// its shelf.

#include <optional>

#include "server/core/description/notify_description.h"
#include "server/core/records/notify_records.h"

namespace driftwise::application {

// Local time of the computer.
struct LocalTime {
  int weekday = 0;  // 0: Monday
  int minute = 0;   // of the day
};
LocalTime local_time(UtcTime utc);

bool in_hours(const ReceiverDescription& receiver, LocalTime at);
// By its level and kind. What a receiver itself does not take is told to the others only.
bool is_routed(const ReceiverDescription& receiver, const AlarmRecord& alarm);

struct DueNews {
  NewsKind kind = NewsKind::firing;
  CellTime at;  // may lie ahead
};

inline constexpr double kForget_s = 7 * 86'400;

struct NewsQuestion {
  const ReceiverDescription& receiver;
  const AlarmRecord& alarm;
  const TellingRecord* told = nullptr;  // nullptr: nothing yet
  CellTime receiver_known_since;
  bool open = true;       // the receiver's hours, now
  bool open_then = true;  // ... when the alarm began
  CellTime now = {};
};
// Nothing: not now, and not without another change of the alarm or of the hours.
std::optional<DueNews> due_news(const NewsQuestion& question);
// Nothing more will ever be told, whatever becomes of the alarm.
bool is_finished(const NewsQuestion& question);

}  // namespace driftwise::application
