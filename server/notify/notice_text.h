#pragma once
// A message in words, for mails and commands. Pure.

#include <string>

#include "server/core/records/notify_records.h"

namespace driftwise::notify {

// One line: "[cell-a] high: laser-x does not answer (and 2 more)".
std::string title_of(const Notice& notice);
// A paragraph for each alarm: what, since when, what follows from it; then the notice's remedy.
std::string text_of(const Notice& notice);

// What the severity is called in Prometheus' conventions: info, warning, critical.
std::string_view severity_of(const AlarmRecord& alarm);
// False while nothing could be stored: nobody can acknowledge it yet. Of a watchdog: never.
bool is_on_record(const Notice& notice, const AlarmRecord& alarm);
// Whether all of it is over.
bool is_resolved(const Notice& notice);
// The number of the alarm, the same for the same condition: 16 hexadecimal digits.
std::string fingerprint_of(const std::string& cell, const AlarmRecord& alarm);

}  // namespace driftwise::notify
