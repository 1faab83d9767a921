#include "clients/cli/core/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "server/core/cell_time.h"

namespace driftwise::cli {
namespace {

std::string print(const char* format, int digits, double value) {
  if (std::isnan(value)) return "-";
  char buffer[400];
  std::snprintf(buffer, sizeof buffer, format, digits, value);
  return buffer;
}

// "-0.0" and "+0.0" say nothing that "0.0" does not.
std::string without_sign_of_zero(std::string text) {
  const bool has_sign = text.size() > 1 && (text.front() == '-' || text.front() == '+');
  if (has_sign && text.find_first_not_of("-+0.") == std::string::npos) text.erase(0, 1);
  return text;
}

CellTime cell_time_from(const google::protobuf::Timestamp& time) {
  constexpr std::int64_t kMostS = 9'000'000'000;  // what 64 bits of nanoseconds hold
  return {std::clamp(time.seconds(), -kMostS, kMostS) * 1'000'000'000 + time.nanos()};
}

}  // namespace

std::string fixed(double value, int decimals) {
  return without_sign_of_zero(print("%.*f", decimals, value));
}
std::string significant(double value, int digits) { return print("%.*g", digits, value); }
std::string signed_fixed(double value, int decimals) {
  return without_sign_of_zero(print("%+.*f", decimals, value));
}

std::string iso_text(const google::protobuf::Timestamp& time) {
  return to_iso8601(cell_time_from(time));
}

std::string clock_text(const google::protobuf::Timestamp& time) {
  std::string text = iso_text(time).substr(0, 19);
  text[10] = ' ';
  return text;
}

std::string utc_text(const google::protobuf::Timestamp& time) { return clock_text(time) + " UTC"; }

double seconds_of(const google::protobuf::Duration& duration) {
  return static_cast<double>(duration.seconds()) + duration.nanos() * 1e-9;
}

double seconds_between(const google::protobuf::Timestamp& from,
                       const google::protobuf::Timestamp& to) {
  return static_cast<double>(to.seconds() - from.seconds()) + (to.nanos() - from.nanos()) * 1e-9;
}

std::string span_text(double seconds) {
  if (std::isnan(seconds)) return "-";
  char buffer[64];
  if (seconds < 0) return "-" + span_text(-seconds);
  if (!(seconds < 1e12)) return significant(seconds, 3) + " s";  // no number of days
  const auto whole = static_cast<long long>(std::llround(seconds));
  if (seconds < 1)
    std::snprintf(buffer, sizeof buffer, "%.1f ms", seconds * 1e3);
  else if (seconds < 60)
    std::snprintf(buffer, sizeof buffer, "%.1f s", seconds);
  else if (whole < 3600)
    std::snprintf(buffer, sizeof buffer, "%lld min %02lld s", whole / 60, whole % 60);
  else if (whole < 2 * 86400)
    std::snprintf(buffer, sizeof buffer, "%lld h %02lld min", whole / 3600, whole / 60 % 60);
  else
    std::snprintf(buffer, sizeof buffer, "%lld d %02lld h", whole / 86400, whole / 3600 % 24);
  return buffer;
}

std::optional<double> number_from(const std::string& text) {
  double value = 0;
  const char* first = text.data();
  const char* last = first + text.size();
  if (first != last && *first == '+') ++first;
  const auto [end, bad] = std::from_chars(first, last, value);
  if (bad != std::errc{} || end != last || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace driftwise::cli
