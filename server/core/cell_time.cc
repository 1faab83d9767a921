#include "server/core/cell_time.h"

#include <charconv>
#include <cstdio>

#include "server/core/reasons.h"

namespace driftwise {
namespace {

constexpr std::int64_t kNsPerSecond = 1'000'000'000;

bool read_digits(std::string_view text, std::size_t at, std::size_t count, int& value) {
  if (at + count > text.size()) return false;
  value = 0;
  for (std::size_t i = at; i < at + count; ++i) {
    if (text[i] < '0' || text[i] > '9') return false;
    value = value * 10 + (text[i] - '0');
  }
  return true;
}

tl::unexpected<Error> bad_time(std::string_view text) {
  return fail(ErrorCode::invalid_argument, reasons::kBadTime,
              "'" + std::string(text) +
                  "' is no time: expected 2026-11-21T08:04:59Z or with a fraction of seconds");
}

}  // namespace

std::string to_iso8601(CellTime time) {
  using namespace std::chrono;
  std::int64_t seconds = time.utc_ns / kNsPerSecond;
  std::int64_t fraction = time.utc_ns % kNsPerSecond;
  if (fraction < 0) {
    fraction += kNsPerSecond;
    --seconds;
  }
  const sys_seconds instant{std::chrono::seconds(seconds)};
  const sys_days day = floor<days>(instant);
  const year_month_day date{day};
  const hh_mm_ss clock{instant - day};
  char text[64];
  int size = std::snprintf(
      text, sizeof text, "%04d-%02u-%02uT%02d:%02d:%02d", static_cast<int>(date.year()),
      static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
      static_cast<int>(clock.hours().count()), static_cast<int>(clock.minutes().count()),
      static_cast<int>(clock.seconds().count()));
  std::string out(text, static_cast<std::size_t>(size));
  if (fraction != 0) {
    size = std::snprintf(text, sizeof text, ".%09lld", static_cast<long long>(fraction));
    out.append(text, static_cast<std::size_t>(size));
    out.erase(out.find_last_not_of('0') + 1);
  }
  return out + "Z";
}

Result<CellTime> parse_iso8601(std::string_view text) {
  using namespace std::chrono;
  int year{}, month{}, day{}, hour{}, minute{}, second{};
  const bool shape = text.size() >= 20 && text.back() == 'Z' && text[4] == '-' && text[7] == '-' &&
                     text[10] == 'T' && text[13] == ':' && text[16] == ':' &&
                     read_digits(text, 0, 4, year) && read_digits(text, 5, 2, month) &&
                     read_digits(text, 8, 2, day) && read_digits(text, 11, 2, hour) &&
                     read_digits(text, 14, 2, minute) && read_digits(text, 17, 2, second);
  if (!shape) return bad_time(text);
  const year_month_day date{std::chrono::year(year),
                            std::chrono::month(static_cast<unsigned>(month)),
                            std::chrono::day(static_cast<unsigned>(day))};
  // 1970..2261 is what 64 bits of nanoseconds hold.
  if (!date.ok() || year < 1970 || year > 2261 || hour > 23 || minute > 59 || second > 59)
    return bad_time(text);
  std::int64_t fraction = 0;
  if (text.size() > 20) {
    const std::string_view digits = text.substr(20, text.size() - 21);
    if (text[19] != '.' || digits.empty() || digits.size() > 9) return bad_time(text);
    const auto [end, code] =
        std::from_chars(digits.data(), digits.data() + digits.size(), fraction);
    if (code != std::errc{} || end != digits.data() + digits.size() || digits.front() == '-')
      return bad_time(text);
    for (std::size_t i = digits.size(); i < 9; ++i) fraction *= 10;
  }
  const auto instant = sys_days(date) + hours(hour) + minutes(minute) + seconds(second);
  return CellTime{duration_cast<std::chrono::seconds>(instant.time_since_epoch()).count() *
                      kNsPerSecond +
                  fraction};
}

}  // namespace driftwise
