#include "server/core/description/certificate_description.h"

#include <chrono>

namespace driftwise {

std::optional<CalendarDay> calendar_day_from(const std::string& text) {
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return std::nullopt;
  int parts[3] = {0, 0, 0};
  int part = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (i == 4 || i == 7) {
      ++part;
      continue;
    }
    if (text[i] < '0' || text[i] > '9') return std::nullopt;
    parts[part] = 10 * parts[part] + (text[i] - '0');
  }
  const std::chrono::year_month_day day{std::chrono::year(parts[0]),
                                        std::chrono::month(static_cast<unsigned>(parts[1])),
                                        std::chrono::day(static_cast<unsigned>(parts[2]))};
  if (!day.ok()) return std::nullopt;
  return CalendarDay{std::chrono::sys_days(day).time_since_epoch().count()};
}

std::optional<std::int64_t> CertificateDescription::days_left(std::int64_t utc_ns) const {
  const auto day = calendar_day_from(due);
  if (!day) return std::nullopt;
  constexpr std::int64_t kDay_ns = 86'400'000'000'000;
  const std::int64_t today = utc_ns / kDay_ns - (utc_ns % kDay_ns < 0 ? 1 : 0);
  return day->days - today;
}

}  // namespace driftwise
