#pragma once
// A move's named coordinates -> one number per axis, in the order of the cell's axes.

#include <google/protobuf/repeated_field.h>

#include <vector>

#include "driftwise/v1/values.pb.h"
#include "server/core/description/cell_description.h"
#include "server/core/result.h"

namespace driftwise::rpc {

// Every motor coordinate of the cell, once, in mm; with several robots those of one robot at least,
// and kMissing for the robots that are not named: they stay where they are. Errors:
// invalid_argument; those of values_from, and UNKNOWN_AXIS, MISSING_COORDINATE, naming the axes
// there are. Soft limits are the cell's business.
Result<std::vector<double>> motor_coordinates_from(
    const google::protobuf::RepeatedPtrField<v1::ChannelValue>& coordinates,
    const CellDescription& cell);

}  // namespace driftwise::rpc
