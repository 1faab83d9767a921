#include "server/application/upkeep/disk_forecast.h"

#include <fmt/format.h>

#include <algorithm>

namespace driftwise::application {
namespace {

constexpr double kBytesPerMegabyte = 1e6, kHour_s = 3600, kHoursPerDay = 24;

// Room for all but the backups.
double room(const DiskSample& sample) {
  return static_cast<double>(sample.free_bytes + sample.backup_bytes);
}

}  // namespace

void DiskForecast::take(const DiskSample& sample, CopiesToCome copies) {
  samples_.push_back(sample);
  copies_ = copies;
  // The oldest one that stays is at the window's beginning or before it.
  while (samples_.size() > 2 && seconds_from(sample.at - samples_[1].at) >= kWindow_s)
    samples_.pop_front();
}

double DiskForecast::bytes_per_hour() const {
  if (samples_.size() < 2) return 0;
  const auto &first = samples_.front(), &last = samples_.back();
  const double passed_s = seconds_from(last.at - first.at);
  if (passed_s < kShortest_s) return 0;
  const auto grown = static_cast<double>(last.record_bytes - first.record_bytes);
  return std::max({grown, room(first) - room(last), 0.0}) / passed_s * kHour_s;
}

std::optional<double> DiskForecast::days() const {
  if (samples_.empty()) return std::nullopt;
  const auto& now = samples_.back();
  const double rate = bytes_per_hour();
  double free = static_cast<double>(now.free_bytes);
  for (std::size_t made = 0; made < copies_.count; ++made) {
    const double copy_h = static_cast<double>(made + 1) * copies_.every_h;
    if (free < rate * copy_h) break;  // full before that copy
    free -= static_cast<double>(now.record_bytes);
    if (free < rate * copy_h) return copy_h / kHoursPerDay;
  }
  if (rate <= 0) return std::nullopt;
  return free / rate / kHoursPerDay;
}

std::string DiskForecast::warning(const std::string& path) const {
  const auto left = days();
  if (!left || *left > kWarn_days) return {};
  const auto& now = samples_.back();
  const auto megabytes = [](std::int64_t bytes) {
    return static_cast<double>(bytes) / kBytesPerMegabyte;
  };
  const std::string when = *left < 2 ? fmt::format("{:.0f} hours", *left * kHoursPerDay)
                                     : fmt::format("{:.0f} days", *left);
  const std::string copies =
      copies_.count == 0 ? std::string()
                         : fmt::format(
                               " and the schedule of backups still adds {} copies of {:.0f} "
                               "MB",
                               copies_.count, megabytes(now.record_bytes));
  return fmt::format(
      "the disk of {} is full in {}: {:.0f} MB are free, it fills by {:.2g} MB an hour{}; make "
      "room, keep fewer backups, or move them to another disk",
      path, when, megabytes(now.free_bytes), bytes_per_hour() / kBytesPerMegabyte, copies);
}

}  // namespace driftwise::application
