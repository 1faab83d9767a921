#pragma once
// Cell time: monotonic, suspend included, also across restarts; it begins as UTC and never steps
// (UTC of an instant: utc_map.h). A simulated cell may run faster: then every dwell, scan, control
// loop and age runs in cell time while I/O time-outs stay in real time.

#include <chrono>
#include <cstdint>
#include <string>

#include "server/core/result.h"

namespace driftwise {

using Nanoseconds = std::chrono::nanoseconds;  // a duration of cell time

struct CellTime {
  std::int64_t utc_ns = 0;  // nanoseconds since 1970-01-01, by a wall clock that nobody sets

  auto operator<=>(const CellTime&) const = default;
  friend CellTime operator+(CellTime t, Nanoseconds d) { return {t.utc_ns + d.count()}; }
  friend CellTime operator-(CellTime t, Nanoseconds d) { return {t.utc_ns - d.count()}; }
  friend Nanoseconds operator-(CellTime a, CellTime b) { return Nanoseconds(a.utc_ns - b.utc_ns); }
};

// An instant of cell time, and how far it is from the daemon's start.
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
