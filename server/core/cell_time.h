#pragma once
// Cell time: the time in which the cell lives. At speed 1 it is UTC; a simulated cell may run
// faster, and then every dwell, scan, control loop and age runs in cell time while I/O time-outs
// stay in wall time.

#include <chrono>
#include <cstdint>
#include <string>

#include "server/core/result.h"

namespace driftwise {

using Nanoseconds = std::chrono::nanoseconds;  // a duration of cell time

struct CellTime {
  std::int64_t utc_ns = 0;  // nanoseconds since 1970-01-01T00:00:00Z, without leap seconds

  auto operator<=>(const CellTime&) const = default;
  friend CellTime operator+(CellTime t, Nanoseconds d) { return {t.utc_ns + d.count()}; }
  friend CellTime operator-(CellTime t, Nanoseconds d) { return {t.utc_ns - d.count()}; }
  friend Nanoseconds operator-(CellTime a, CellTime b) { return Nanoseconds(a.utc_ns - b.utc_ns); }
};

// UTC says when, the monotonic stamp says in which order and how long: it never runs back.
struct Stamp {
  CellTime utc;
  std::int64_t monotonic_ns = 0;  // cell nanoseconds since this daemon started
};

constexpr double seconds_from(Nanoseconds d) { return static_cast<double>(d.count()) * 1e-9; }
// The longest duration: 100 years. An instant of this century and such a duration add up within 64
// bits. A number of seconds beyond it, which no door lets in, becomes it; NaN becomes 0.
constexpr double kLongest_s = 100 * 365.25 * 86'400;
constexpr Nanoseconds nanoseconds_from_s(double seconds) {
  if (!(seconds > -kLongest_s)) seconds = seconds < 0 ? -kLongest_s : 0;
  if (seconds > kLongest_s) seconds = kLongest_s;
  return Nanoseconds(static_cast<std::int64_t>(seconds * 1e9 + (seconds < 0 ? -0.5 : 0.5)));
}
// What a request or a cell file may ask for: a year.
constexpr double kMostAsked_s = 366 * 86'400.0;

// "2026-11-21T08:04:59.123456789Z"; trailing zeros of the fraction are dropped.
std::string to_iso8601(CellTime time);
// Errors: invalid_argument, reason BAD_TIME. Accepts a fraction of 0 to 9 digits and only 'Z'.
Result<CellTime> parse_iso8601(std::string_view text);

}  // namespace driftwise
