#include "server/application/models/formula_check.h"

#include "server/application/models/fit_options.h"
#include "server/calibration/design/design.h"
#include "server/calibration/linear/orthogonal_set.h"
#include "server/calibration/linear/rank.h"
#include "server/calibration/linear/row_reduction.h"
#include "server/calibration/selection/selection_rule.h"
#include "server/core/data/unusable_values.h"
#include "server/core/try.h"
#include "server/effects/term_order.h"
#include "server/formats/formula/formula.h"

namespace driftwise::application {
namespace {

constexpr std::size_t kMostSentences = 20;

// Errors of the formula mark their place: "...:\n  q ~ x + ?\n          ^". Its column is that of
// the caret while the text is whole, which is so for what a person types.
std::optional<std::size_t> marked_place(const std::string& message, const std::string& formula) {
  const auto caret = message.rfind("\n");
  const auto text = caret == std::string::npos ? caret : message.rfind('\n', caret - 1);
  if (text == std::string::npos || message.back() != '^') return std::nullopt;
  if (message.substr(text + 1, caret - text - 1) != "  " + formula) return std::nullopt;
  return message.size() - 1 - (caret + 1) - 2;
}

// Lets the columns in one by one, as a fit of all of them would have to.
void count_rank(const calibration::Design& design, FormulaCheck& check) {
  check.columns = static_cast<int>(design.terms.size());
  if (design.row_count() == 0) return;
  const calibration::RowReduction rows(design, {0, design.row_count()},
                                       calibration::Solver::automatic, {});
  const auto triangle = rows.all();
  calibration::OrthogonalSet set(triangle.columns, triangle.outputs.col(0), triangle.beyond[0],
                                 triangle.rows, triangle.columns.colwise().norm());
  for (int j = 0; j < check.columns; ++j) {
    if (!set.collinear(j)) {
      set.enter(j);
      ++check.rank;
    } else if (check.look_alikes.size() < kMostSentences) {
      check.look_alikes.push_back(calibration::collinear_sentence(design, set, j));
    }
  }
}

Result<void> look(const Dataset& dataset, const FitRequest& request, FormulaCheck& check) {
  if (const auto usable = without_unusable(dataset)) return look(usable->data, request, check);
  DRIFTWISE_TRY(auto options, fit_options_from(request, dataset, ""));
  DRIFTWISE_TRY(const auto formula, formats::Formula::parse(request.formula));
  check.canonical = formula.canonical();
  DRIFTWISE_TRY(auto candidates, formula.expand(dataset));
  check.outputs = candidates.outputs;
  for (const auto& term : candidates.terms) check.terms.push_back(effects::notation(term));
  options.candidates = std::move(candidates);
  DRIFTWISE_TRY(const auto design, calibration::make_design(dataset, options));
  check.calibration = design.row_count();
  check.validation = design.validation;
  check.dropped = design.dropped;
  count_rank(design, check);
  return calibration::check_options(options);
}

}  // namespace

FormulaCheck check_formula_on(const Dataset& dataset, const FitRequest& request) {
  FormulaCheck check;
  for (const auto& column : dataset.columns) check.channels.push_back(column.channel);
  if (!dataset.dwell_s.empty()) check.channels.push_back({"dwell", "s"});
  if (const auto looked = look(dataset, request, check); !looked) {
    check.problem = looked.error().message;
    check.problem_offset = marked_place(check.problem, request.formula);
  }
  return check;
}

}  // namespace driftwise::application
