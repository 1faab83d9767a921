#include "server/rpc/watch/series_request.h"

#include <algorithm>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/rpc/shared/request_checks.h"
#include "server/rpc/shared/request_times.h"

namespace driftwise::rpc {
namespace {

constexpr int kMostBuckets = 10'000, kMostChannels = 200;
constexpr std::int64_t kMostBucketsInAll = 1'000'000, kNanosecondsPerSecond = 1'000'000'000;

Result<void> take_channels(const v1::GetSeriesRequest& request, SeriesQuery& out) {
  if (request.channels().empty() || request.channels_size() > kMostChannels)
    return fail(ErrorCode::invalid_argument, reasons::kBadChannel,
                "channels: found " + std::to_string(request.channels_size()) +
                    " of them, expected 1 to " + std::to_string(kMostChannels));
  for (const auto& name : request.channels()) {
    if (const auto channel = parse_robot_channel(name); !channel)
      return fail(ErrorCode::invalid_argument, reasons::kBadChannel,
                  "channels: " + channel.error().message);
    if (std::find(out.channels.begin(), out.channels.end(), name) != out.channels.end())
      return fail(ErrorCode::invalid_argument, reasons::kBadChannel,
                  "channels: " + name + " is named twice");
    out.channels.push_back(name);
  }
  return {};
}

Result<void> take_buckets(const v1::GetSeriesRequest& request, SeriesQuery& out) {
  out.buckets = request.bucket_count();
  if (out.buckets < 1 || out.buckets > kMostBuckets)
    return fail(ErrorCode::invalid_argument, reasons::kBadBuckets,
                "bucket_count: found " + std::to_string(out.buckets) + ", expected 1 to " +
                    std::to_string(kMostBuckets));
  if (std::int64_t{out.buckets} * request.channels_size() > kMostBucketsInAll)
    return fail(ErrorCode::resource_exhausted, reasons::kTooManyBuckets,
                "bucket_count times channels is above 1 000 000: ask for fewer of either");
  return {};
}

}  // namespace

Awaitable<Result<SeriesQuery>> series_query_from(const v1::GetSeriesRequest& request,
                                                 const application::Host& host,
                                                 application::Runs& runs) {
  SeriesQuery out;
  DRIFTWISE_CO_RETURN_IF_ERROR(take_channels(request, out));
  DRIFTWISE_CO_RETURN_IF_ERROR(take_buckets(request, out));
  out.to = host.now();
  out.from = {};
  if (request.has_run_id()) {
    DRIFTWISE_CO_RETURN_IF_ERROR(check_id(request.run_id(), "run_id"));
    out.run = RunId{request.run_id()};
    DRIFTWISE_CO_TRY(const auto run, co_await runs.get(*out.run));
    out.from = run.started.utc_ns != 0 ? run.started : run.created;
    if (run.ended.utc_ns != 0) out.to = {run.ended.utc_ns + 1};
  }
  for (const bool is_from : {true, false}) {
    if (is_from ? !request.has_from_time() : !request.has_to_time()) continue;
    DRIFTWISE_CO_TRY(const auto time,
                     instant_from(is_from ? request.from_time() : request.to_time(),
                                  is_from ? "from_time" : "to_time"));
    (is_from ? out.from : out.to) = time;
  }
  if (out.from.utc_ns == 0 && !request.has_from_time())
    out.from = {out.to.utc_ns - 3600 * kNanosecondsPerSecond};
  if (out.from.utc_ns >= out.to.utc_ns)
    co_return fail(ErrorCode::invalid_argument, reasons::kBadRange,
                   "from_time is not before to_time: expected a range of at least 1 us");
  co_return out;
}

}  // namespace driftwise::rpc
