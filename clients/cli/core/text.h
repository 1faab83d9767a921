#pragma once
// Numbers and times as people read them.

#include <google/protobuf/duration.pb.h>
#include <google/protobuf/timestamp.pb.h>

#include <optional>
#include <string>

namespace driftwise::cli {

std::string fixed(double value, int decimals);         // "12.30"; "-" for NaN
std::string significant(double value, int digits);     // "1.234e-05" where that is shorter
std::string signed_fixed(double value, int decimals);  // "+12.3"

std::string clock_text(const google::protobuf::Timestamp& time);  // "2026-11-21 08:04:59"
std::string utc_text(const google::protobuf::Timestamp& time);    // "2026-11-21 08:04:59 UTC"
std::string iso_text(const google::protobuf::Timestamp& time);  // "2026-11-21T08:04:59.123456789Z"
double seconds_of(const google::protobuf::Duration& duration);
double seconds_between(const google::protobuf::Timestamp& from,
                       const google::protobuf::Timestamp& to);
std::string span_text(double seconds);  // "4 h 02 min", "12.3 s"

// "3" or "1.25e-3" -> number; nothing when the text is anything else, not finite included.
std::optional<double> number_from(const std::string& text);

}  // namespace driftwise::cli
