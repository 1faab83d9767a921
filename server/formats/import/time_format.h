#pragma once
// When a row was measured, as other programs write it -> an instant.

#include <cstdint>
#include <string>
#include <string_view>

#include "server/core/cell_time.h"

namespace driftwise::formats {

// "iso8601": date and time parted by T or a blank, fraction of up to 9 digits, then Z, an offset
//   such as +02:00, or nothing (local time: utc_offset_h counts);
// "unix_s", "unix_ms", "unix_us", "unix_ns": since 1970-01-01T00:00:00Z;
// "labview_s": seconds since 1904-01-01T00:00:00Z; "excel_days": days since 1899-12-30, local time;
// "seconds", "minutes", "hours": since any start;
// else a pattern of %Y %y %m %d %H %I %M %S %f (1 to 9 digits of a fraction) %p %b %% and literal
//   text, local time.
class TimeFormat {
 public:
  // Errors: invalid_argument BAD_TIME_FORMAT naming what is wrong with the pattern.
  static Result<TimeFormat> parse(std::string_view text, double utc_offset_h);

  // decimal: of numbers, in the file. Errors: invalid_argument BAD_TIME, the sentence only (the
  // caller knows file, line and column).
  Result<CellTime> read(std::string_view text, char decimal) const;

  // Whether a text that read() takes says no zone: it is by a clock that may be set back in autumn.
  bool is_local(std::string_view text) const;
  // Whether read gives a real instant, or one counted from any start.
  bool has_epoch() const { return kind_ != Kind::elapsed; }
  const std::string& text() const { return text_; }

 private:
  enum class Kind : std::uint8_t { iso8601, number, elapsed, pattern };
  Result<CellTime> read_iso8601(std::string_view text) const;
  Result<CellTime> read_number(std::string_view text, char decimal) const;
  Result<CellTime> read_pattern(std::string_view text) const;

  Kind kind_ = Kind::iso8601;
  std::string text_;
  double seconds_per_unit_ = 1;
  std::int64_t zero_utc_ns_ = 0;    // where the count begins
  std::int64_t utc_offset_ns_ = 0;  // of local times
};

}  // namespace driftwise::formats
