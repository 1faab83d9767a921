#include "server/identification/set_table.h"

#include <charconv>
#include <cmath>
#include <span>

#include "server/calibration/datum_zeros.h"
#include "server/calibration/design/predict.h"
#include "server/core/data/unusable_values.h"
#include "server/core/reasons.h"
#include "server/core/text/trimmed.h"
#include "server/core/try.h"
#include "server/effects/direct_symbols.h"
#include "server/identification/bench.h"

namespace driftwise::identification {
namespace {

std::string trimmed(std::string_view text) { return std::string(driftwise::trimmed(text, " \t")); }

bool number(std::string_view text, double& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && std::isfinite(value);
}

tl::unexpected<Error> bad_set(const std::string& found) {
  return fail(ErrorCode::invalid_argument, reasons::kBadSet,
              "found '" + found.substr(0, 80) +
                  "', expected a name and ranges of channels, such as \"inside: force 0.7..0.8\"");
}

bool holds(const Dataset& dataset, std::size_t row, const NamedSet& set,
           const std::vector<std::string>& words) {
  if (!set.word.empty() && (row >= words.size() || words[row] != set.word)) return false;
  for (const auto& one : set.conditions) {
    const double value = dataset.find(one.symbol)->values[row];
    if (!(value >= one.low && value <= one.high)) return false;
  }
  return true;
}

tl::unexpected<Error> no_rows(const std::string& set, std::size_t marked, std::size_t known) {
  std::string sentence = "set '" + set + "': none of the " + std::to_string(marked) +
                         " rows marked validation is in it";
  if (known < marked)
    sentence += "; " + std::to_string(marked - known) +
                " of them do not count: their datum has no calibration rows";
  return fail(ErrorCode::invalid_argument, reasons::kNoRows, sentence);
}

struct JudgedFit {
  std::vector<Channel> outputs;
  std::int64_t terms = 0;
  Eigen::MatrixXd errors;  // rows x outputs; NaN in rows without a value
};

Result<JudgedFit> errors_of(const Dataset& dataset, const NamedFit& named) {
  calibration::FitOptions options = named.fit;
  options.blocks = 0;
  DRIFTWISE_TRY(const auto model, calibration::fit(dataset, options));
  JudgedFit judged;
  for (const auto& output : model.outputs) {
    judged.outputs.push_back(output.channel);
    judged.terms += static_cast<std::int64_t>(output.terms.size());
  }
  DRIFTWISE_TRY(auto measured, measured_outputs(dataset, judged.outputs));
  judged.errors = std::move(measured);
  const Dataset moved = calibration::in_first_datum(dataset, model.datum_zeros);
  for (std::size_t o = 0; o < model.outputs.size(); ++o) {
    DRIFTWISE_TRY(const auto predicted, calibration::predict(moved, model.outputs[o]));
    judged.errors.col(static_cast<Eigen::Index>(o)) -= predicted;
  }
  // A fit leaves out a row that lacks a channel of any term that was offered.
  for (const auto& term : options.candidates.terms)
    for (const auto& symbol : effects::symbols_read_at_once(term))
      if (const auto* column = dataset.find(symbol))
        for (std::size_t row = 0; row < dataset.rows; ++row)
          if (is_missing(column->values[row]))
            judged.errors.row(static_cast<Eigen::Index>(row)).setConstant(kMissing);
  return judged;
}

std::vector<std::size_t> complete_rows(const std::vector<std::size_t>& rows,
                                       const Eigen::MatrixXd& errors) {
  std::vector<std::size_t> complete;
  for (const std::size_t row : rows)
    if (errors.row(static_cast<Eigen::Index>(row)).allFinite()) complete.push_back(row);
  return complete;
}

}  // namespace

Result<NamedSet> named_set_from(const std::string& text) {
  const auto colon = text.find(':');
  NamedSet set{.name = trimmed(std::string_view(text).substr(0, colon)), .conditions = {}};
  if (set.name.empty()) return bad_set(text);
  if (colon == std::string::npos) {
    if (set.name.find_first_of(" \t") != std::string::npos) return bad_set(text);  // no colon
    return set;
  }
  for (std::size_t at = colon + 1; at <= text.size();) {
    const std::size_t comma = std::min(text.find(',', at), text.size());
    const std::string item = trimmed(std::string_view(text).substr(at, comma - at));
    const auto blank = item.find(' '), dots = item.find("..");
    RowCondition condition;
    if (blank == std::string::npos || dots == std::string::npos || dots < blank ||
        !number(trimmed(std::string_view(item).substr(blank, dots - blank)), condition.low) ||
        !number(trimmed(std::string_view(item).substr(dots + 2)), condition.high) ||
        condition.low > condition.high)
      return bad_set(text);
    condition.symbol = item.substr(0, blank);
    set.conditions.push_back(std::move(condition));
    at = comma + 1;
  }
  return set;
}

Result<SetTable> set_table(const Dataset& whole, const std::vector<NamedFit>& models,
                           const std::vector<NamedSet>& sets,
                           const std::vector<std::string>& words) {
  if (const auto usable = without_unusable(whole))
    return set_table(usable->data, models, sets, words);
  SetTable table;
  const auto marked = rows_in(whole, PointSet::validation);
  const auto known = validation_rows_known(whole, rows_in(whole, PointSet::calibration));
  table.rows_unknown_datum = static_cast<std::int64_t>(marked.size() - known.size());
  std::vector<std::vector<std::size_t>> rows_of;
  for (const auto& set : sets) {
    for (const auto& one : set.conditions)
      if (whole.find(one.symbol) == nullptr)
        return fail(
            ErrorCode::invalid_argument, reasons::kUnknownChannel,
            "set '" + set.name + "': the data have no channel '" + one.symbol.substr(0, 80) + "'");
    auto& rows = rows_of.emplace_back();
    for (const std::size_t row : known)
      if (holds(whole, row, set, words)) rows.push_back(row);
    if (rows.empty()) return no_rows(set.name, marked.size(), known.size());
    table.sets.push_back(set.name);
    table.rows.push_back(static_cast<std::int64_t>(rows.size()));
  }
  for (const auto& named : models) {
    DRIFTWISE_TRY(const auto judged, errors_of(whole, named));
    table.models.push_back(named.name);
    table.terms.push_back(judged.terms);
    for (std::size_t s = 0; s < sets.size(); ++s) {
      const auto rows = complete_rows(rows_of[s], judged.errors);
      if (rows.empty())
        return fail(ErrorCode::invalid_argument, reasons::kNoRows,
                    "model '" + named.name + "', set '" + sets[s].name + "': none of its " +
                        std::to_string(rows_of[s].size()) +
                        " rows has a value of every channel that the model reads");
      SetCell cell{.model = named.name,
                   .set = sets[s].name,
                   .rows = static_cast<std::int64_t>(rows.size()),
                   .outputs = {}};
      for (std::size_t o = 0; o < judged.outputs.size(); ++o) {
        const Eigen::VectorXd errors = picked(judged.errors, rows, static_cast<Eigen::Index>(o));
        cell.outputs.push_back(
            {judged.outputs[o],
             error_figures(std::span(errors.data(), static_cast<std::size_t>(errors.size())))});
      }
      table.cells.push_back(std::move(cell));
    }
  }
  return table;
}

}  // namespace driftwise::identification
