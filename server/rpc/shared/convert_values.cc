#include "server/rpc/shared/convert_values.h"

#include <cmath>

#include "server/core/channel.h"
#include "server/core/reasons.h"
#include "server/core/text/clean_text.h"
#include "server/rpc/shared/wire_time.h"

namespace driftwise::rpc {
namespace {

constexpr std::int64_t kNsPerS = 1'000'000'000;
constexpr int kMostValues = 64;

}  // namespace

google::protobuf::Timestamp timestamp_from(CellTime time) { return timestamp_from(utc_from(time)); }

google::protobuf::Timestamp timestamp_from(UtcTime time) {
  std::int64_t seconds = time.ns / kNsPerS, rest = time.ns % kNsPerS;
  if (rest < 0) {  // nanos count forward, also before 1970
    rest += kNsPerS;
    --seconds;
  }
  google::protobuf::Timestamp out;
  out.set_seconds(seconds);
  out.set_nanos(static_cast<std::int32_t>(rest));
  return out;
}

google::protobuf::Duration duration_from(Nanoseconds duration) {
  google::protobuf::Duration out;
  out.set_seconds(duration.count() / kNsPerS);
  out.set_nanos(static_cast<std::int32_t>(duration.count() % kNsPerS));
  return out;
}

google::protobuf::Duration duration_from_s(double seconds) {
  if (!std::isfinite(seconds) || std::abs(seconds) > 1e9) return {};
  return duration_from(nanoseconds_from_s(seconds));
}

Result<Nanoseconds> nanoseconds_from(const google::protobuf::Duration& duration,
                                     const char* field) {
  constexpr std::int64_t kMostS = 366LL * 86400;
  if (duration.seconds() < 0 || duration.nanos() < 0 || duration.nanos() >= kNsPerS ||
      duration.seconds() > kMostS)
    return fail(ErrorCode::invalid_argument, reasons::kBadDuration,
                std::string(field) + ": found " + std::to_string(duration.seconds()) + " s " +
                    std::to_string(duration.nanos()) + " ns, expected 0 to one year");
  return Nanoseconds(duration.seconds() * kNsPerS + duration.nanos());
}

std::string utf8_from(std::string text) { return clean_text(text); }

void set_value(v1::ChannelValue& out, const std::string& channel, double value) {
  out.set_channel(channel);
  if (!is_missing(value)) out.set_value(value);
}

void add_values(const std::vector<ChannelValue>& values,
                google::protobuf::RepeatedPtrField<v1::ChannelValue>& out) {
  out.Reserve(static_cast<int>(values.size()));
  for (const auto& value : values) set_value(*out.Add(), value.channel, value.value);
}

v1::Reading reading_from(const Reading& reading) {
  v1::Reading out;
  out.set_device_id(reading.device);
  *out.mutable_start_time() = timestamp_from(reading.start);
  *out.mutable_end_time() = timestamp_from(reading.end);
  out.set_sequence(reading.sequence);
  add_values(reading.values, *out.mutable_values());
  return out;
}

Result<std::vector<ChannelValue>> values_from(
    const google::protobuf::RepeatedPtrField<v1::ChannelValue>& values, const char* field) {
  const auto bad = [field](std::string reason, std::string what) {
    return fail(ErrorCode::invalid_argument, std::move(reason),
                std::string(field) + ": " + std::move(what));
  };
  if (values.size() > kMostValues)
    return bad(reasons::kTooManyValues,
               "found " + std::to_string(values.size()) + " values, expected at most 64");
  std::vector<ChannelValue> out;
  for (const auto& value : values) {
    if (auto channel = parse_robot_channel(value.channel()); !channel)
      return bad(channel.error().reason, channel.error().message);
    if (!value.has_value()) return bad(reasons::kMissingValue, value.channel() + " has no value");
    if (!std::isfinite(value.value()))
      return bad(reasons::kNotFinite, value.channel() + " is not a finite number");
    for (const auto& earlier : out)
      if (earlier.channel == value.channel())
        return bad(reasons::kDuplicateChannel, value.channel() + " stands twice");
    out.push_back({value.channel(), value.value()});
  }
  return out;
}

}  // namespace driftwise::rpc
