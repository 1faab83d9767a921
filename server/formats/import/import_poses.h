#pragma once
// A measured pose -> the wanted one, row by row.

#include "server/core/data/dataset.h"
#include "server/formats/import/import_mapping.h"

namespace driftwise::formats {

// frame * measured * tool for every row; channels that do not exist yet are added at the end. A row
// in which a coordinate is missing gives no pose. The rule's input channels are in the dataset.
void apply_pose(const PoseRule& rule, Dataset& dataset);

}  // namespace driftwise::formats
