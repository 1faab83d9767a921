#include "server/diagnosis/rows/rows_needed.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "server/core/data/row_marks.h"
#include "server/core/reasons.h"
#include "server/diagnosis/rows/problem.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

// Of the baseline, left beside frozen ones: the gate leaves every second short block out.
constexpr std::size_t kRowsPerTerm = 2;
constexpr double kMostFrozen = 0.3;  // of the rows, of a thermometer that no baseline reads

std::string count_text(std::size_t count) {
  return std::to_string(count) + (count == 1 ? " row" : " rows");
}

std::string are(std::size_t count) { return count_text(count) + (count == 1 ? " is " : " are "); }

// Rows not left out that lack a value of the channel.
std::size_t lacking(const Dataset& data, const DatasetColumn& column) {
  std::size_t count = 0;
  for (std::size_t row = 0; row < data.rows; ++row)
    count += !data.is_excluded(row) && !std::isfinite(column.values[row]) ? 1 : 0;
  return count;
}

// A sentence for each kind of row that teaches nothing, with what to do about it.
std::vector<std::string> losses(const Problem& problem) {
  const Dataset& data = problem.data();
  std::vector<std::string> result;
  if (const std::size_t left_out = count_kept_out(data); left_out > 0)
    result.push_back(are(left_out) +
                     "left out (marked excluded, the same as an earlier row, or without a value "
                     "of a condition): take back the marks that are wrong");
  if (problem.judged_by_validation)
    result.push_back(are(problem.judge.size()) +
                     "marked validation and only judge: mark rows to learn from as calibration in "
                     "column set");
  else if (!problem.judge.empty())
    result.push_back(are(problem.judge.size()) + "kept out to judge by: measure more");
  const auto outputs = problem.output_symbols();
  std::set<std::string> read;
  for (const auto& term : problem.base)
    for (auto& symbol : effects::symbols_of(term)) read.insert(std::move(symbol));
  for (const auto& column : data.columns) {
    const std::string& symbol = column.channel.symbol;
    const bool is_output = std::ranges::find(outputs, symbol) != outputs.end();
    if (!is_output && !read.contains(symbol)) continue;
    if (const std::size_t count = lacking(data, column); count > 0)
      result.push_back(symbol + " has no value in " + count_text(count) +
                       (is_output ? ": measure it, or name another output"
                                  : ": leave it out of the baseline, or measure it"));
  }
  return result;
}

}  // namespace

Result<void> check_rows_needed(const Problem& problem) {
  const std::size_t wanted = problem.base.size() + kRowsBeyondBase, found = problem.learn.size();
  if (found >= wanted) return {};
  std::string why;
  for (const auto& loss : losses(problem)) why += (why.empty() ? "" : "; ") + loss;
  return fail(ErrorCode::invalid_argument, reasons::kTooFewRows,
              "a diagnosis of this baseline needs " + count_text(wanted) +
                  " to learn from, and finds " + std::to_string(found) + " in data of " +
                  count_text(count_rows_of_plan(problem.data())) + ": " +
                  (why.empty() ? "measure more, or leave terms out of the baseline" : why));
}

std::vector<std::string> rows_left_out(const Problem& problem) {
  const Dataset& data = problem.data();
  std::vector<char> used(data.rows, 0);
  for (const auto* rows : {&problem.learn, &problem.judge})
    for (const std::size_t row : *rows) used[row] = 1;
  std::set<std::int64_t> known;
  if (!data.datum.empty())
    for (const std::size_t row : problem.learn) known.insert(data.datum[row]);
  std::size_t incomplete = 0, unknown = 0;
  for (std::size_t row = 0; row < data.rows; ++row) {
    if (used[row] != 0 || data.is_excluded(row)) continue;
    const bool has_no_datum =
        !data.datum.empty() && is_complete(problem, row) && !known.contains(data.datum[row]);
    ++(has_no_datum ? unknown : incomplete);
  }
  std::vector<std::string> said;
  if (incomplete > 0)
    said.push_back(
        std::to_string(incomplete) + " of " + std::to_string(count_rows_of_plan(data)) +
        (incomplete == 1 ? " rows is left out: it lacks" : " rows are left out: they lack") +
        " a value of an output or of a term of the baseline");
  if (unknown > 0)
    said.push_back(std::to_string(unknown) +
                   (unknown == 1 ? " validation row" : " validation rows") +
                   " left out: their datum has no calibration rows to take its constant from");
  return said;
}

LivingBaseline without_dead_sensors(const calibration::Candidates& baseline, const Dataset& dataset,
                                    const std::vector<FaultySensor>& sensors) {
  LivingBaseline result{.baseline = baseline, .dead = {}};
  const bool any_learns =
      dataset.set.empty() || std::ranges::count(dataset.set, PointSet::calibration) > 0;
  std::vector<char> learns(dataset.rows);
  for (std::size_t row = 0; row < dataset.rows; ++row)
    learns[row] =
        !dataset.is_excluded(row) && (!any_learns || dataset.set_of(row) == PointSet::calibration);
  for (const auto& sensor : sensors) {
    if (sensor.fault != SensorFault::frozen) continue;
    const auto reads = [&](const effects::Term& term) {
      return std::ranges::count(effects::symbols_of(term), sensor.channel) > 0;
    };
    auto& terms = result.baseline.terms;
    const bool is_read = std::ranges::any_of(terms, reads);
    std::vector<char> left = learns;
    for (const std::size_t row : sensor.rows) left[row] = 0;
    const auto count = static_cast<std::size_t>(std::ranges::count(left, 1));
    const double frozen =
        static_cast<double>(sensor.rows.size()) / static_cast<double>(dataset.rows);
    if (is_read ? count < kRowsPerTerm * (terms.size() + 1) : frozen >= kMostFrozen) {
      result.dead.push_back(sensor.channel);
      std::erase_if(terms, reads);
    } else if (is_read) {
      learns = std::move(left);
    }
  }
  return result;
}

}  // namespace driftwise::diagnosis
