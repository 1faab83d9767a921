#include "server/application/upkeep/disk_forecast.h"

#include <fmt/format.h>

namespace driftwise::application {
namespace {

constexpr double kBytesPerMegabyte = 1e6, kHour_s = 3600, kHoursPerDay = 24;

}  // namespace

void DiskForecast::take(CellTime at, std::int64_t record_bytes, std::int64_t free_bytes) {
  samples_.push_back({at, record_bytes});
  free_bytes_ = free_bytes;
  // The oldest one that stays is at the window's beginning or before it.
  while (samples_.size() > 2 && seconds_from(at - samples_[1].at) >= kWindow_s)
    samples_.pop_front();
}

double DiskForecast::bytes_per_hour() const {
  if (samples_.size() < 2) return 0;
  const double passed_s = seconds_from(samples_.back().at - samples_.front().at);
  if (passed_s < kShortest_s) return 0;
  const auto grown = static_cast<double>(samples_.back().bytes - samples_.front().bytes);
  return grown > 0 ? grown / passed_s * kHour_s : 0;
}

std::optional<double> DiskForecast::days() const {
  const double rate = bytes_per_hour();
  if (rate <= 0) return std::nullopt;
  return static_cast<double>(free_bytes_) / rate / kHoursPerDay;
}

std::string DiskForecast::warning(const std::string& path) const {
  const auto left = days();
  if (!left || *left > kWarn_days) return {};
  const std::string when = *left < 2 ? fmt::format("{:.0f} hours", *left * kHoursPerDay)
                                     : fmt::format("{:.0f} days", *left);
  return fmt::format(
      "the disk of {} is full in {}: {:.0f} MB are free, the record grows by {:.2g} MB an hour; "
      "make room, or move backups to another disk",
      path, when, static_cast<double>(free_bytes_) / kBytesPerMegabyte,
      bytes_per_hour() / kBytesPerMegabyte);
}

}  // namespace driftwise::application
