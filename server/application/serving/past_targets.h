#pragma once
// What a model would have answered for one pose in the hours before now, made from the recorded
// temperatures: a page that was just opened sees where the correction comes from.

#include <optional>
#include <vector>

#include "server/application/serving/targets.h"
#include "server/calibration/model/model.h"
#include "server/core/description/cell_description.h"
#include "server/core/ports/store.h"
#include "server/core/records/records.h"

namespace driftwise::application {

struct PastModel {
  calibration::Model model;
  ModelId id;
  std::optional<DatumRecord> datum;  // the present one: all instants count from its zero
  bool own_datum = false;            // it is the one that the model was fitted in
};

// Reads the means of every slow channel of the model between two instants, and those before the
// first that effects with memory need (six hours, SnapshotBuilder::memory()). In a carried datum
// such effects count as they stood at its zero, by the readings before that.
// Pure but for the store. Errors: those of SnapshotBuilder::create, anchor and of a target that is
// refused for what the request states (MISSING_COORDINATE, NOT_FINITE); of the store.
Result<PastTargets> past_targets(Store& store, const CellDescription& cell, PastModel from,
                                 const PastTargetsQuery& query, CellTime now);

}  // namespace driftwise::application
