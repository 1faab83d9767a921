#pragma once
// The pose that the serving model gives for what was read: what a return to zero is expected to
// show. Pure over the board's snapshot.

#include <optional>
#include <vector>

#include "server/compensation/snapshot_board.h"
#include "server/core/data/reading.h"
#include "server/core/ids.h"

namespace driftwise::application {

struct ModelPose {
  ModelId model;
  std::vector<ChannelValue> values;  // x_mm .., rx_arcsec ..: those that the motors decide
};

// values: motor coordinates in mm, rotations and force as read. None: no model serves, it cannot
// answer, or the conditions are outside its range, stale or missing.
std::optional<ModelPose> model_pose(const compensation::SnapshotBoard& board,
                                    const std::vector<ChannelValue>& values);

}  // namespace driftwise::application
