#pragma once
// The standards' options and figures, proto <-> domain.

#include "driftwise/v1/standards_service.pb.h"
#include "server/standards/iso230_2.h"
#include "server/standards/iso230_3.h"
#include "server/standards/iso9283.h"

namespace driftwise::rpc {

standards::Iso2302Options options_from(const v1::EvaluateIso2302Request& request);
standards::Iso2303Options options_from(const v1::EvaluateIso2303Request& request);
standards::Iso9283Options options_from(const v1::EvaluateIso9283Request& request);

void put(const standards::Iso2302& figures, v1::EvaluateIso2302Response& out);
void put(const standards::Iso2303& figures, v1::EvaluateIso2303Response& out);
void put(const standards::Iso9283& figures, v1::EvaluateIso9283Response& out);

}  // namespace driftwise::rpc
