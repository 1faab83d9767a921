#pragma once
// Times, channel values and readings: domain -> proto, and the requests' numbers -> domain with
// their checks.

#include <google/protobuf/duration.pb.h>
#include <google/protobuf/repeated_field.h>
#include <google/protobuf/timestamp.pb.h>

#include <cstdint>
#include <string>
#include <vector>

#include "driftwise/v1/values.pb.h"
#include "server/core/data/reading.h"
#include "server/core/result.h"
#include "server/core/utc_map.h"

namespace driftwise::rpc {

// Rows of a run's trajectory: the record counts from 0, the API and every client from 1.
constexpr std::int64_t shown_row(std::int64_t stored) { return stored + 1; }
constexpr std::int64_t stored_row(std::int64_t shown) { return shown - 1; }

google::protobuf::Timestamp timestamp_from(CellTime time);  // its UTC: wire_time.h
google::protobuf::Timestamp timestamp_from(UtcTime time);
google::protobuf::Duration duration_from(Nanoseconds duration);
google::protobuf::Duration duration_from_s(double seconds);  // not finite or beyond 1e9 s: 0

// Errors: invalid_argument, BAD_DURATION, naming the field: negative, malformed, or longer than a
// year.
Result<Nanoseconds> nanoseconds_from(const google::protobuf::Duration& duration, const char* field);

// The door out: a proto string must hold valid UTF-8, and what devices, files and older records
// hold must not command a terminal (core/clean_text.h).
std::string utf8_from(std::string text);

void set_value(v1::ChannelValue& out, const std::string& channel,
               double value);  // kMissing leaves it absent
void add_values(const std::vector<ChannelValue>& values,
                google::protobuf::RepeatedPtrField<v1::ChannelValue>& out);
v1::Reading reading_from(const Reading& reading);

// Named values of a request. Errors: invalid_argument; TOO_MANY_VALUES (more than 64), BAD_CHANNEL,
// MISSING_VALUE, NOT_FINITE, DUPLICATE_CHANNEL, each naming the field and the channel.
Result<std::vector<ChannelValue>> values_from(
    const google::protobuf::RepeatedPtrField<v1::ChannelValue>& values, const char* field);

}  // namespace driftwise::rpc
