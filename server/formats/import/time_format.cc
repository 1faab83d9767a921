#include "server/formats/import/time_format.h"

#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <system_error>

#include "server/core/reasons.h"
#include "server/formats/import/number_style.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

constexpr std::int64_t kNsPerSecond = 1'000'000'000;

struct Count {
  std::string_view name;
  double seconds;
  std::int64_t zero_s;  // from 1970-01-01
  bool elapsed, local;
};
constexpr std::array kCounts = {
    Count{"unix_s", 1, 0, false, false},
    Count{"unix_ms", 1e-3, 0, false, false},
    Count{"unix_us", 1e-6, 0, false, false},
    Count{"unix_ns", 1e-9, 0, false, false},
    Count{"labview_s", 1, -2'082'844'800, false, false},
    Count{"excel_days", 86400, -2'209'161'600, false, true},
    Count{"seconds", 1, 0, true, false},
    Count{"minutes", 60, 0, true, false},
    Count{"hours", 3600, 0, true, false},
};

constexpr std::array<std::string_view, 12> kMonths = {"jan", "feb", "mar", "apr", "may", "jun",
                                                      "jul", "aug", "sep", "oct", "nov", "dec"};

tl::unexpected<Error> bad_format(const std::string& sentence) {
  return fail(ErrorCode::invalid_argument, reasons::kBadTimeFormat, sentence);
}

tl::unexpected<Error> unreadable_time(std::string_view text, const std::string& expected) {
  return fail(ErrorCode::invalid_argument, reasons::kBadTime,
              "found " + shown(text) + ", expected " + expected);
}

// Digits with or without a sign, to the last of them.
std::optional<std::int64_t> whole_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

struct CivilTime {
  int year = -1, month = 1, day = 1, hour = 0, minute = 0, second = 0;
  std::int64_t fraction_ns = 0;
};

// What 64 bits of nanoseconds hold, and a calendar day.
std::optional<std::int64_t> utc_ns_of(const CivilTime& t) {
  using namespace std::chrono;
  const year_month_day date{year(t.year), month(static_cast<unsigned>(t.month)),
                            day(static_cast<unsigned>(t.day))};
  if (!date.ok() || t.year < 1900 || t.year > 2261 || t.hour > 23 || t.minute > 59 || t.second > 60)
    return std::nullopt;
  const auto instant = sys_days(date) + hours(t.hour) + minutes(t.minute) + seconds(t.second);
  return duration_cast<std::chrono::seconds>(instant.time_since_epoch()).count() * kNsPerSecond +
         t.fraction_ns;
}

// Walks over a text; each function says whether what it wants stood there.
struct TimeCursor {
  std::string_view rest;

  bool literal(char c) {
    if (rest.empty() || rest.front() != c) return false;
    rest.remove_prefix(1);
    return true;
  }
  bool digits(std::size_t least, std::size_t most, int& value) {
    std::size_t count = 0;
    value = 0;
    while (count < most && count < rest.size() && rest[count] >= '0' && rest[count] <= '9')
      value = value * 10 + (rest[count++] - '0');
    rest.remove_prefix(count);
    return count >= least;
  }
  bool fraction(std::int64_t& ns) {
    const std::size_t before = rest.size();
    int value = 0;
    if (!digits(1, 9, value)) return false;
    ns = value;
    for (std::size_t i = before - rest.size(); i < 9; ++i) ns *= 10;
    return true;
  }
  bool word(std::string_view lower) {
    if (rest.size() < lower.size()) return false;
    for (std::size_t i = 0; i < lower.size(); ++i)
      if ((rest[i] | 0x20) != lower[i]) return false;
    rest.remove_prefix(lower.size());
    return true;
  }
  bool month_name(int& month) {
    for (std::size_t i = 0; i < kMonths.size(); ++i)
      if (word(kMonths[i])) return month = static_cast<int>(i) + 1, true;
    return false;
  }
};

bool read_field(char letter, TimeCursor& at, CivilTime& time, int& half_day) {
  switch (letter) {
    case 'Y':
      return at.digits(4, 4, time.year);
    case 'y':
      if (!at.digits(2, 2, time.year)) return false;
      time.year += time.year < 69 ? 2000 : 1900;  // as POSIX strptime
      return true;
    case 'm':
      return at.digits(1, 2, time.month);
    case 'd':
      return at.digits(1, 2, time.day);
    case 'H':
      return at.digits(1, 2, time.hour);
    case 'I':
      return at.digits(1, 2, time.hour) && time.hour >= 1 && time.hour <= 12;
    case 'M':
      return at.digits(1, 2, time.minute);
    case 'S':
      return at.digits(1, 2, time.second);
    case 'f':
      return at.fraction(time.fraction_ns);
    case 'b':
      return at.month_name(time.month);
    case 'p':
      half_day = at.word("am") ? 1 : at.word("pm") ? 2 : -1;
      return half_day > 0;
    default:
      return at.literal('%');
  }
}

}  // namespace

Result<TimeFormat> TimeFormat::parse(std::string_view text, double utc_offset_h) {
  TimeFormat out;
  out.text_ = text;
  out.utc_offset_ns_ = std::llround(utc_offset_h * 3600) * kNsPerSecond;
  if (text == "iso8601") return out;
  for (const auto& count : kCounts) {
    if (text != count.name) continue;
    out.kind_ = count.elapsed ? Kind::elapsed : Kind::number;
    out.seconds_per_unit_ = count.seconds;
    out.zero_utc_ns_ =
        count.zero_s * kNsPerSecond - (count.local ? out.utc_offset_ns_ : std::int64_t{0});
    return out;
  }
  out.kind_ = Kind::pattern;
  std::string seen;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') continue;
    const char letter = i + 1 < text.size() ? text[++i] : ' ';
    if (std::string_view("YymdHIMSfpb%").find(letter) == std::string_view::npos)
      return bad_format("found %" + std::string(1, letter) + " in " + shown(text) +
                        ", expected %Y %y %m %d %H %I %M %S %f %p %b or %%");
    if (letter != '%' && seen.find(letter) != std::string::npos)
      return bad_format("found %" + std::string(1, letter) + " twice in " + shown(text));
    seen += letter;
  }
  const auto has = [&](char letter) { return seen.find(letter) != std::string::npos; };
  if (!(has('Y') || has('y')) || !(has('m') || has('b')) || !has('d'))
    return bad_format("found " + shown(text) +
                      ", expected iso8601, unix_s, unix_ms, unix_us, unix_ns, labview_s, "
                      "excel_days, seconds, minutes, hours, or a pattern with at least a year, a "
                      "month and a day such as %Y-%m-%d %H:%M:%S");
  if (has('I') != has('p'))
    return bad_format("found only one of %I and %p in " + shown(text) +
                      ", expected both or neither");
  return out;
}

Result<CellTime> TimeFormat::read(std::string_view text, char decimal) const {
  switch (kind_) {
    case Kind::iso8601:
      return read_iso8601(text);
    case Kind::pattern:
      return read_pattern(text);
    default:
      return read_number(text, decimal);
  }
}

Result<CellTime> TimeFormat::read_number(std::string_view text, char decimal) const {
  constexpr const char* kExpected = "a number of ";
  const auto number = number_in(text, {.decimal = decimal});
  // Up to the year 2200 in nanoseconds, with room for the zero.
  if (!number || std::abs(*number * seconds_per_unit_) > 7e9)
    return unreadable_time(text, kExpected + text_ + " (the mapping's time.format)");
  // The whole part in whole nanoseconds, so that a long count keeps its fraction. Of a count of
  // nanoseconds a double would keep 53 of 61 bits.
  const std::int64_t ns_per_unit = std::llround(seconds_per_unit_ * 1e9);
  if (const auto whole = whole_number(text)) return CellTime{zero_utc_ns_ + *whole * ns_per_unit};
  const double whole = std::trunc(*number), part = *number - whole;
  return CellTime{zero_utc_ns_ + static_cast<std::int64_t>(whole) * ns_per_unit +
                  std::llround(part * static_cast<double>(ns_per_unit))};
}

Result<CellTime> TimeFormat::read_iso8601(std::string_view text) const {
  constexpr const char* kExpected = "a time such as 2026-11-21T08:04:59.5+02:00";
  TimeCursor at{text};
  CivilTime time;
  bool good = at.digits(4, 4, time.year) && at.literal('-') && at.digits(2, 2, time.month) &&
              at.literal('-') && at.digits(2, 2, time.day) &&
              (at.literal('T') || at.literal(' ')) && at.digits(2, 2, time.hour) &&
              at.literal(':') && at.digits(2, 2, time.minute);
  if (good && at.literal(':')) good = at.digits(2, 2, time.second);
  if (good && (at.literal('.') || at.literal(','))) good = at.fraction(time.fraction_ns);
  std::int64_t offset_ns = utc_offset_ns_;
  if (good && at.literal('Z')) {
    offset_ns = 0;
  } else if (good && !at.rest.empty()) {
    const bool west = at.rest.front() == '-';
    int hours = 0, minutes = 0;
    good = (at.literal('+') || at.literal('-')) && at.digits(2, 2, hours);
    if (good && !at.rest.empty()) {
      at.literal(':');
      good = at.digits(2, 2, minutes);
    }
    good = good && hours <= 14 && minutes <= 59;
    offset_ns = (west ? -1 : 1) * (hours * 3600 + minutes * 60) * kNsPerSecond;
  }
  const auto utc_ns = good && at.rest.empty() ? utc_ns_of(time) : std::nullopt;
  if (!utc_ns) return unreadable_time(text, kExpected);
  return CellTime{*utc_ns - offset_ns};
}

Result<CellTime> TimeFormat::read_pattern(std::string_view text) const {
  TimeCursor at{text};
  CivilTime time;
  int half_day = 0;  // 1 am, 2 pm
  bool good = true;
  for (std::size_t i = 0; good && i < text_.size(); ++i)
    good = text_[i] == '%' ? read_field(text_[++i], at, time, half_day) : at.literal(text_[i]);
  if (half_day != 0) time.hour = time.hour % 12 + (half_day == 2 ? 12 : 0);
  const auto utc_ns = good && at.rest.empty() ? utc_ns_of(time) : std::nullopt;
  if (!utc_ns)
    return unreadable_time(text, "a time as in " + shown(text_) + " (the mapping's time.format)");
  return CellTime{*utc_ns - utc_offset_ns_};
}

bool TimeFormat::is_local(std::string_view text) const {
  constexpr std::size_t kDate = 10;  // "2026-10-25": its hyphens are no sign
  if (kind_ == Kind::pattern) return true;
  if (kind_ == Kind::iso8601)
    return !text.ends_with('Z') && !text.ends_with('z') &&
           text.find_first_of("+-", kDate) == std::string_view::npos;
  return text_ == "excel_days";
}

}  // namespace driftwise::formats
