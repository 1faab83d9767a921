#include "server/application/improvement/plan_rows.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/application/datasets/declared_channels.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/diagnosis/rows/rows_needed.h"
#include "server/formats/formula/formula.h"

namespace driftwise::application {

Result<void> check_plan_rows(const CellDescription& cell, const Trajectory& plan,
                             const std::string& text) {
  DRIFTWISE_TRY(const auto formula, formats::Formula::parse(text));
  DRIFTWISE_RETURN_IF_ERROR(check_formula_reads(cell, text));
  DRIFTWISE_TRY(const auto candidates, formula.expand(declared_channels(cell)));
  const auto of = [&plan](PointSet set) {
    return static_cast<std::size_t>(std::ranges::count(plan.points, set, &TrajectoryPoint::set));
  };
  const std::size_t validation = of(PointSet::validation);
  std::size_t rows = of(PointSet::calibration);
  std::string held_out;
  if (validation == 0) {
    held_out = fmt::format(" (a fifth of its {} is held out)", rows);
    rows -= rows / 5;
  } else if (rows == 0) {  // nothing to learn from but the validation rows
    rows = validation;
  }
  const std::size_t terms = candidates.terms.size() + 1;  // the constant
  const std::size_t needed = terms + diagnosis::kRowsBeyondBase;
  if (rows >= needed) return {};
  return fail(
      ErrorCode::invalid_argument, reasons::kTooFewRows,
      fmt::format("the plan has {} rows to learn from{}; {} has {} terms, and a diagnosis of "
                  "it needs {} rows at least: nothing was moved. Measure more positions, or "
                  "offer fewer terms",
                  rows, held_out, text, terms, needed));
}

}  // namespace driftwise::application
