#include "server/rpc/run/convert_verification.h"

#include "server/rpc/run/convert_run.h"
#include "server/rpc/shared/convert_accuracy.h"

namespace driftwise::rpc {

v1::VerifyRunsResponse verification_from(const diagnosis::Verification& verification,
                                         std::span<const RunRecord> runs) {
  v1::VerifyRunsResponse out;
  for (std::size_t i = 0; i < verification.runs.size(); ++i) {
    const auto& run = verification.runs[i];
    auto& to = *out.add_runs();
    if (i < runs.size()) *to.mutable_run() = run_from(runs[i]);
    to.set_row_count(run.rows);
    to.set_outside_row_count(run.rows_outside);
    to.set_zero_row_count(run.rows_zero);
    to.mutable_outside()->Add(run.outside.begin(), run.outside.end());
    for (const auto& one : run.coordinates) {
      auto& coordinate = *to.add_coordinates();
      coordinate.set_coordinate(one.channel.symbol);
      coordinate.set_unit(one.unit);
      *coordinate.mutable_all() = figures_from(one.all);
      *coordinate.mutable_inside() = figures_from(one.inside);
      *coordinate.mutable_outside() = figures_from(one.outside);
      if (one.by_model) *coordinate.mutable_by_model() = figures_from(*one.by_model);
      coordinate.set_largest(one.largest);
      coordinate.set_largest_row(static_cast<std::int64_t>(one.largest_row) + 1);
      coordinate.mutable_errors()->Add(one.errors.begin(), one.errors.end());
    }
  }
  for (const auto& change : verification.changes) {
    auto& to = *out.add_changes();
    to.set_run_id(change.run.value);
    to.set_against_run_id(change.against.value);
    to.set_position_count(change.positions);
    for (const auto& one : change.coordinates) *to.add_coordinates() = judged_from(one);
  }
  for (const auto& one : verification.heading) *out.add_accuracy() = judged_from(one);
  return out;
}

}  // namespace driftwise::rpc
