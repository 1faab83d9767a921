#pragma once
// The uncertainty budget of a model without a cell at work: at the middle and at a corner of its
// domain, temperatures in the middle of their fitted ranges, the model's own datum. Pure.

#include <string>
#include <vector>

#include "server/calibration/model/model.h"
#include "server/compensation/snapshot.h"
#include "server/compensation/target.h"
#include "server/core/description/cell_description.h"

namespace driftwise::compensation {

// Errors: those of SnapshotBuilder::create.
Result<Snapshot> model_snapshot(const calibration::Model& model, const CellDescription& cell);

struct BudgetPlace {
  std::string name;  // "centre"; "corner": every coordinate at the upper end of its range
  TargetRequest request;
  std::vector<ChannelValue> pose;  // the same, for people
};
std::vector<BudgetPlace> budget_places(const Snapshot& snapshot);

// The largest line of any output at any of those places.
struct LargestLine {
  UncertaintySource source = UncertaintySource::fit;
  double u_nm = 0;
  double combined_u_nm = 0;  // of all lines, there
};
std::optional<LargestLine> largest_line(const Snapshot& snapshot);

// "beam offset": as pages and command lines write it.
std::string shown_name(UncertaintySource source);
// Whether an instrument or the cell's owner answers for it, not the robot's fit.
bool is_declared(UncertaintySource source);

}  // namespace driftwise::compensation
