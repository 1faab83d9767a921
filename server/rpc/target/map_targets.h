#pragma once
// The targets of a grid of poses from one snapshot: what the correction looks like over the
// workspace.

#include "driftwise/v1/target_service.pb.h"
#include "server/compensation/snapshot.h"
#include "server/core/result.h"

namespace driftwise::rpc {

// Errors: those of pose_from and compute_target; invalid_argument BAD_AXIS (no pose coordinate,
// twice the same, no range, fewer than 2 or more than 200 positions); resource_exhausted
// TOO_MANY_POSES.
Result<void> map_targets(const compensation::Snapshot& snapshot,
                         const v1::MapTargetsRequest& request, CellTime now,
                         v1::MapTargetsResponse& response);

// The same in pieces, for an arm, whose rows take up to a second each. pose: of the first position;
// its last two values are those of the axes. row: 0 to vertical.count() - 1, in their order.
struct TargetMap {
  v1::MapAxis horizontal, vertical;
  google::protobuf::RepeatedPtrField<v1::ChannelValue> pose;
};
Result<TargetMap> begin_map(const compensation::Snapshot& snapshot,
                            const v1::MapTargetsRequest& request, v1::MapTargetsResponse& response);
Result<void> add_map_row(const compensation::Snapshot& snapshot, const TargetMap& map, int row,
                         CellTime now, v1::MapTargetsResponse& response);

}  // namespace driftwise::rpc
