#pragma once
// The accuracy that heads whatever shows a model: server/core/data/accuracy.h over its outputs.

#include <vector>

#include "server/calibration/model/model.h"
#include "server/core/data/accuracy.h"

namespace driftwise::calibration {

// Of one output in its summary unit: validation rows, blocks of time, calibration rows, as far as
// the model has them. The number of rows is that of the model's lineage.
std::vector<JudgedAccuracy> judged_accuracies(const OutputModel& output, const Lineage& lineage);

// Worst of the outputs of each unit (nm and arcsec apart) and of validation rows and held-out
// blocks.
std::vector<JudgedAccuracy> heading_of(const Model& model);

// The heading of a model with what another had on the same output and the same rows; without
// before where that has no such figure, or was judged on other data.
std::vector<JudgedAccuracy> heading_of(const Model& model, const Model& before);

}  // namespace driftwise::calibration
