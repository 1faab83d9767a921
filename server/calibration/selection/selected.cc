#include "server/calibration/selection/selected.h"

#include <algorithm>

#include "server/calibration/linear/rank.h"
#include "server/core/reasons.h"
#include "server/effects/term_order.h"

namespace driftwise::calibration {
namespace {

using Eigen::Index;

// Every term concerned and what it equals, by letting the terms in one by one.
tl::unexpected<Error> rank_error(const Design& design, const Triangle& triangle,
                                 const std::vector<int>& deficient) {
  const Eigen::VectorXd norms = triangle.columns.colwise().norm();
  OrthogonalSet set(triangle.columns, triangle.outputs.col(0), triangle.beyond[0], triangle.rows,
                    norms);
  for (int j = 0; j < static_cast<int>(design.terms.size()); ++j)
    if (std::ranges::find(deficient, j) == deficient.end() && !set.collinear(j)) set.enter(j);
  std::string sentences;
  for (const int j : deficient)
    sentences += (sentences.empty() ? "" : "; ") + collinear_sentence(design, set, j);
  return fail(ErrorCode::failed_precondition, reasons::kRankDeficient,
              sentences + ": leave these terms out, or measure where they differ");
}

}  // namespace

Result<std::vector<Fitted>> select_and_solve(const Design& design, const Triangle& triangle,
                                             const SelectionRule& rule, const Executor& executor) {
  std::vector<Fitted> fitted;
  for (Index o = 0; o < static_cast<Index>(design.outputs.size()); ++o) {
    if (!rule.stepwise && (o == 0 || !rule.left_out.empty())) {
      std::vector<int> every;
      for (int j = 0; j < static_cast<int>(design.terms.size()); ++j)
        if (!rule.leaves_out(o, j)) every.push_back(j);
      const Solution trial = solve(triangle, design.basis, every, o);
      if (!trial.deficient.empty()) return rank_error(design, triangle, trial.deficient);
    }
    auto [selection, starts] =
        select_from_starts(triangle, design.basis, design.always, o, rule, executor);
    for (const int column : selection.unestimable)
      if (!effects::datum_of(design.terms[static_cast<std::size_t>(column)]))
        return rank_error(design, triangle, {column});
    Solution solution = solve(triangle, design.basis, selection.set.order(), o);
    if (!solution.deficient.empty()) return rank_error(design, triangle, solution.deficient);
    if (!solution.coefficients.allFinite())
      return fail(ErrorCode::invalid_argument, reasons::kBadValue,
                  "the coefficients of " + design.outputs[static_cast<std::size_t>(o)].symbol +
                      " leave the range of double precision: use other units");
    fitted.push_back({std::move(selection), std::move(starts), std::move(solution)});
  }
  return fitted;
}

}  // namespace driftwise::calibration
