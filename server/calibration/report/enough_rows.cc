#include "server/calibration/report/enough_rows.h"

#include <algorithm>
#include <set>
#include <string>

#include "server/core/data/reading.h"
#include "server/core/reasons.h"
#include "server/effects/term_order.h"

namespace driftwise::calibration {
namespace {

// What of the formula has no value in most of the rows that should teach it: "t01 has no value in
// 300 of 300 calibration rows"; empty when nothing is missing.
std::string most_missing(const Dataset& dataset, const Design& design) {
  std::set<std::string> read;
  for (const auto& term : design.terms)
    for (auto& symbol : effects::symbols_of(term)) read.insert(std::move(symbol));
  for (const auto& output : design.outputs) read.insert(output.symbol);
  std::size_t rows = 0, most = 0;
  for (std::size_t row = 0; row < dataset.rows; ++row)
    if (dataset.set_of(row) == PointSet::calibration) ++rows;
  std::string who;
  for (const auto& column : dataset.columns) {
    if (!read.contains(column.channel.symbol)) continue;
    std::size_t missing = 0;
    for (std::size_t row = 0; row < dataset.rows; ++row)
      if (dataset.set_of(row) == PointSet::calibration && is_missing(column.values[row])) ++missing;
    if (missing <= most) continue;
    most = missing;
    who = column.channel.symbol;
  }
  return most == 0 ? ""
                   : who + " has no value in " + std::to_string(most) + " of " +
                         std::to_string(rows) + " calibration rows";
}

std::string advice(const Dataset& dataset, const Design& design) {
  bool any = false;
  for (std::size_t row = 0; row < dataset.rows && !any; ++row)
    any = dataset.set_of(row) == PointSet::calibration;
  if (!any)
    return "every row is marked validation: mark those to learn from as calibration in column set";
  const auto missing = most_missing(dataset, design);
  return missing.empty() ? "measure more, or offer fewer terms"
                         : missing + ": leave it out of the formula, or measure it";
}

}  // namespace

Result<void> check_enough_rows(const Dataset& dataset, const Design& design,
                               const FitOptions& options) {
  const auto rows = static_cast<std::int64_t>(design.rows.size());
  const auto certain = std::ranges::count(design.always, 1);
  const bool all = options.select == Select::all;
  const auto needed = all ? static_cast<std::int64_t>(design.terms.size()) + 1 : certain + 2;
  if (rows >= needed) return {};
  const auto terms = all ? static_cast<std::int64_t>(design.terms.size()) : certain;
  return fail(ErrorCode::failed_precondition, reasons::kTooFewRows,
              std::to_string(rows) + " complete calibration rows (" +
                  std::to_string(design.dropped) + " dropped for missing values), at least " +
                  std::to_string(needed) + " are needed for " + std::to_string(terms) +
                  (terms == 1 ? " term" : " terms") +
                  (all          ? ""
                   : terms == 1 ? " that is always in"
                                : " that are always in") +
                  ": " + advice(dataset, design));
}

}  // namespace driftwise::calibration
