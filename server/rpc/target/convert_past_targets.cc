#include "server/rpc/target/convert_past_targets.h"

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/rpc/shared/convert_values.h"
#include "server/rpc/target/convert_target.h"

namespace driftwise::rpc {

Result<application::PastTargetsQuery> past_targets_query_from(
    const v1::ListPastTargetsRequest& request) {
  application::PastTargetsQuery query;
  DRIFTWISE_TRY(const auto pose, pose_from(request.pose(), CellTime{}));
  query.pose = pose;
  if (request.has_past_duration()) {
    DRIFTWISE_TRY(const auto past, nanoseconds_from(request.past_duration(), "past_duration"));
    query.past = past;
  }
  if (query.past < std::chrono::minutes(1) || query.past > std::chrono::hours(24))
    return fail(ErrorCode::invalid_argument, reasons::kBadPast,
                "past_duration: expected a minute to a day");
  if (request.count() != 0) query.count = request.count();
  if (query.count < 2 || query.count > 500)
    return fail(ErrorCode::invalid_argument, reasons::kBadCount,
                "count: expected 2 to 500 instants, found " + std::to_string(query.count));
  return query;
}

void fill_past_targets(const application::PastTargets& from, v1::ListPastTargetsResponse& out) {
  out.set_model_id(from.model.value);
  for (const CellTime at : from.at) *out.add_times() = timestamp_from(at);
  for (const auto& track : from.tracks) {
    auto& one = *out.add_tracks();
    one.set_channel(track.channel.name());
    one.mutable_correction_nm()->Add(track.correction_nm.begin(), track.correction_nm.end());
  }
}

}  // namespace driftwise::rpc
