#pragma once
// Any message of driftwise.v1 as JSON for programs, by reflection:
//   keys are the proto names; int64 are numbers (proto's own JSON makes texts of them); what is
//   absent is null; a Timestamp is ISO 8601 text; a Duration "x_duration" becomes the number "x_s";
//   an enum value is its name in lower case without the prefix ("running"); a list of ChannelValue
//   becomes one object {"q1_mm": 1.5}; figures of a model's output carry its summary unit in the
//   key ("rmse_nm").

#include <google/protobuf/message.h>

#include <nlohmann/json.hpp>

namespace driftwise::cli {

nlohmann::ordered_json json_from(const google::protobuf::Message& message);

}  // namespace driftwise::cli
