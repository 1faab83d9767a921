#pragma once
// One robot's part of a model, of a cell and of readings, with its id taken off the names: what the
// rooms for one robot work with.

#include <set>
#include <span>
#include <string>
#include <vector>

#include "server/calibration/model/model.h"
#include "server/core/data/reading.h"
#include "server/core/description/cell_description.h"
#include "server/core/result.h"

namespace driftwise::plans {

// Ids of the robots whose motor and pose channels the model gives or reads; "": channels without an
// id.
std::set<std::string> robots_of(const calibration::Model& model);

// Errors: failed_precondition OTHER_ROBOT, where the model gives or reads another robot's channels.
Result<calibration::Model> part_of_robot(calibration::Model model, const std::string& robot);
// Axes, lengths, angles and beams of other robots are left out.
CellDescription part_of_robot(CellDescription cell, const std::string& robot);
std::vector<ChannelValue> part_of_robot(std::span<const ChannelValue> values,
                                        const std::string& robot);

}  // namespace driftwise::plans
