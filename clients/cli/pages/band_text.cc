#include "clients/cli/pages/band_text.h"

#include <array>

#include "clients/cli/core/text.h"

namespace driftwise::cli {
namespace {

constexpr std::int64_t kDay_s = 86'400;

std::int64_t day_of(const google::protobuf::Timestamp& time) { return time.seconds() / kDay_s; }

std::string day_name(const google::protobuf::Timestamp& time) {
  // Day 0 was a Thursday.
  constexpr std::array kNames{"Thu", "Fri", "Sat", "Sun", "Mon", "Tue", "Wed"};
  return kNames[static_cast<std::size_t>(((day_of(time) % 7) + 7) % 7)];
}

std::string minutes_text(const google::protobuf::Timestamp& time) {
  return clock_text(time).substr(11, 5);
}

}  // namespace

std::string end_text(const google::protobuf::Timestamp& end,
                     const google::protobuf::Timestamp& earliest,
                     const google::protobuf::Timestamp& latest, double share) {
  const auto beside = [&end](const google::protobuf::Timestamp& time) {
    return (day_of(time) == day_of(end) ? "" : day_name(time) + " ") + minutes_text(time);
  };
  return day_name(end) + " " + minutes_text(end) + ", " + fixed(100 * share, 0) +
         " %: " + beside(earliest) + " to " + beside(latest);
}

std::string band_text(const v1::DurationBand& band) {
  const std::string runs =
      band.run_count() == 0   ? "; no run of this cell is on record"
      : band.run_count() == 1 ? ", from 1 run of this cell"
                              : ", from " + std::to_string(band.run_count()) + " runs of this cell";
  return fixed(100 * band.share(), 0) + " %: " + span_text(seconds_of(band.low_duration())) +
         " to " + span_text(seconds_of(band.high_duration())) + runs;
}

}  // namespace driftwise::cli
