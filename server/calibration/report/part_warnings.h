#pragma once
// Thermometers that are not on the robot in a model of its motor coordinates.

#include <string>
#include <vector>

#include "server/calibration/model/model.h"
#include "server/core/data/dataset.h"

namespace driftwise::calibration {

// One sentence per part with thermometers in the terms that are in. Nothing where the data do not
// say on which part a thermometer is (server/core/data/dataset_parts.h), or no output is a motor
// coordinate.
std::vector<std::string> part_warnings(const Dataset& dataset, const Model& model);

}  // namespace driftwise::calibration
