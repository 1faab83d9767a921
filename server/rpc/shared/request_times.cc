#include "server/rpc/shared/request_times.h"

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/rpc/shared/wire_time.h"

namespace driftwise::rpc {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

}  // namespace

Result<CellTime> instant_from(const google::protobuf::Timestamp& time, const char* field) {
  constexpr std::int64_t kMostSeconds = 9'000'000'000;  // 64 bits of nanoseconds reach 2262
  if (time.seconds() < 0 || time.seconds() > kMostSeconds || time.nanos() < 0 ||
      time.nanos() >= kSecond_ns)
    return fail(ErrorCode::invalid_argument, reasons::kBadTime,
                std::string(field) + ": expected an instant between 1970 and 2255");
  return cell_time_from(UtcTime{time.seconds() * kSecond_ns + time.nanos()});
}

Result<RequestRange> checked_range(const google::protobuf::Timestamp* from,
                                   const google::protobuf::Timestamp* to, CellTime now) {
  RequestRange range;
  range.to = now;
  if (to != nullptr) {
    DRIFTWISE_TRY(range.to, instant_from(*to, "to_time"));
  }
  range.from = {range.to.utc_ns - 3600 * kSecond_ns};
  if (from != nullptr) {
    DRIFTWISE_TRY(range.from, instant_from(*from, "from_time"));
  }
  if (range.from.utc_ns >= range.to.utc_ns)
    return fail(ErrorCode::invalid_argument, reasons::kBadRange,
                "from_time is not before to_time: expected a stretch of the record");
  return range;
}

}  // namespace driftwise::rpc
