#pragma once
// Time to an end as a band, for people. Times are cell time (UTC at speed 1).

#include <string>

#include "driftwise/v1/run.pb.h"

namespace driftwise::cli {

// "Sun 14:10, 80 %: 13:50 to 14:40"; days that differ are named.
std::string end_text(const google::protobuf::Timestamp& end,
                     const google::protobuf::Timestamp& earliest,
                     const google::protobuf::Timestamp& latest, double share);
// "80 %: 4 h 50 min to 5 h 40 min, from 12 runs of this cell".
std::string band_text(const v1::DurationBand& band);

}  // namespace driftwise::cli
