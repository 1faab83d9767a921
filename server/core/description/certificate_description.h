#pragma once
// Certificate of an instrument: [[certificate]] of the cell file.

#include <cstdint>
#include <optional>
#include <string>

namespace driftwise {

// Day of the calendar, as days since 1970-01-01.
struct CalendarDay {
  std::int64_t days = 0;
};
// "2026-03-01"; nothing for a text that is no day.
std::optional<CalendarDay> calendar_day_from(const std::string& text);

struct CertificateDescription {
  std::string device;      // id in the cell file
  std::string number;      // of the certificate
  std::string laboratory;  // who calibrated
  std::string date;        // "2026-03-01"
  std::string due;         // the same; empty: none stated

  // Days from this UTC instant's day to the due day; below 0: overdue. None: no due date.
  std::optional<std::int64_t> days_left(std::int64_t utc_ns) const;
};

}  // namespace driftwise
