#pragma once
// A stretch of the record as a request names it.

#include <google/protobuf/timestamp.pb.h>

#include "server/application/ports/host.h"
#include "server/core/cell_time.h"
#include "server/core/result.h"

namespace driftwise::rpc {

// Errors: invalid_argument BAD_TIME, naming the field.
Result<CellTime> instant_from(const google::protobuf::Timestamp& time, const char* field);

struct RequestRange {
  CellTime from, to;
};
// to absent: now; from absent: an hour before. Errors: BAD_TIME; BAD_RANGE (not in order).
template <class Request>
Result<RequestRange> range_from(const Request& request, const application::Host& host);

Result<RequestRange> checked_range(const google::protobuf::Timestamp* from,
                                   const google::protobuf::Timestamp* to, CellTime now);

template <class Request>
Result<RequestRange> range_from(const Request& request, const application::Host& host) {
  return checked_range(request.has_from_time() ? &request.from_time() : nullptr,
                       request.has_to_time() ? &request.to_time() : nullptr, host.now());
}

}  // namespace driftwise::rpc
