#include "server/identification/set_table.h"

#include <charconv>
#include <cmath>
#include <span>

#include "server/calibration/design/predict.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/identification/bench.h"

namespace driftwise::identification {
namespace {

std::string trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t"), last = text.find_last_not_of(" \t");
  return first == std::string_view::npos ? "" : std::string(text.substr(first, last - first + 1));
}

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

Result<SetTable> set_table(const Dataset& dataset, const std::vector<NamedFit>& models,
                           const std::vector<NamedSet>& sets,
                           const std::vector<std::string>& words) {
  SetTable table;
  const auto validation = rows_in(dataset, PointSet::validation);
  std::vector<std::vector<std::size_t>> rows_of;
  for (const auto& set : sets) {
    for (const auto& one : set.conditions)
      if (dataset.find(one.symbol) == nullptr)
        return fail(
            ErrorCode::invalid_argument, reasons::kUnknownChannel,
            "set '" + set.name + "': the data have no channel '" + one.symbol.substr(0, 80) + "'");
    auto& rows = rows_of.emplace_back();
    for (const std::size_t row : validation)
      if (holds(dataset, row, set, words)) rows.push_back(row);
    if (rows.empty())
      return fail(ErrorCode::invalid_argument, reasons::kNoRows,
                  "set '" + set.name + "': none of the " + std::to_string(validation.size()) +
                      " rows marked validation is in it");
    table.sets.push_back(set.name);
    table.rows.push_back(static_cast<std::int64_t>(rows.size()));
  }
  for (const auto& named : models) {
    calibration::FitOptions options = named.fit;
    options.blocks = 0;
    DRIFTWISE_TRY(const auto model, calibration::fit(dataset, options));
    std::vector<Channel> outputs;
    std::int64_t terms = 0;
    for (const auto& output : model.outputs) {
      outputs.push_back(output.channel);
      terms += static_cast<std::int64_t>(output.terms.size());
    }
    table.models.push_back(named.name);
    table.terms.push_back(terms);
    DRIFTWISE_TRY(const auto measured, measured_outputs(dataset, outputs));
    std::vector<Eigen::VectorXd> predicted;
    for (const auto& output : model.outputs) {
      DRIFTWISE_TRY(auto one, calibration::predict(dataset, output));
      predicted.push_back(std::move(one));
    }
    for (std::size_t s = 0; s < sets.size(); ++s) {
      SetCell cell{.model = named.name, .set = sets[s].name, .outputs = {}};
      for (std::size_t o = 0; o < outputs.size(); ++o) {
        const auto column = static_cast<Eigen::Index>(o);
        const Eigen::VectorXd errors = picked(measured.col(column) - predicted[o], rows_of[s], 0);
        cell.outputs.push_back(
            {outputs[o],
             error_figures(std::span(errors.data(), static_cast<std::size_t>(errors.size())))});
      }
      table.cells.push_back(std::move(cell));
    }
  }
  return table;
}

}  // namespace driftwise::identification
