#include "server/core/data/stated_lines.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "server/core/data/dataset_parts.h"
#include "server/core/data/measured_by.h"
#include "server/core/data/overruns.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise {
namespace {

using Lines = std::vector<std::pair<std::string, std::string>>;

std::string name_of(const StatedLines& source) {
  std::string numbers;
  for (const RunId run : source.runs)
    numbers += (numbers.empty() ? "" : ", ") + std::to_string(run.value);
  return (source.runs.size() == 1 ? "run " : "runs ") + numbers;
}

using RowsOfSources = std::vector<std::vector<std::size_t>>;  // in the order of the sources

RowsOfSources rows_of(const Dataset& data, std::span<const StatedLines> sources) {
  std::map<std::int64_t, std::size_t> source_of;
  for (std::size_t i = 0; i < sources.size(); ++i)
    for (const RunId run : sources[i].runs) source_of[run.value] = i;
  RowsOfSources rows(sources.size());
  for (std::size_t row = 0; row < data.rows; ++row)
    if (data.run.empty())
      rows.front().push_back(row);
    else if (const auto found = source_of.find(data.run[row]); found != source_of.end())
      rows[found->second].push_back(row);
  return rows;
}

bool has(const Dataset& data, const std::vector<std::size_t>& rows, const std::string& symbol) {
  const auto* column = data.find(symbol);
  return column != nullptr && std::ranges::any_of(rows, [column](const std::size_t row) {
           return !is_missing(column->values[row]);
         });
}

bool states_overruns(const StatedLines& source) {
  return std::ranges::find(source.lines, Lines::value_type(kOverruns, "yes")) != source.lines.end();
}

Result<void> add_overruns(std::span<const StatedLines> sources, Lines& out) {
  const auto yes = std::ranges::find_if(sources, states_overruns);
  if (yes == sources.end()) return {};
  const auto no = std::ranges::find_if_not(sources, states_overruns);
  if (no != sources.end())
    return fail(ErrorCode::invalid_argument, reasons::kMetadataDisagree,
                name_of(*yes) + " states '# overruns: yes' and " + name_of(*no) +
                    " does not: expected the same of all runs that are taken together, as their "
                    "rows follow one path. Take them apart; or, where both were measured so, add "
                    "the line to the other file and import it again");
  out.emplace_back(kOverruns, "yes");
  return {};
}

Result<void> add_parts(const Dataset& data, std::span<const StatedLines> sources,
                       const RowsOfSources& rows, Lines& out) {
  Parts parts;
  std::map<std::string, const StatedLines*> stated_by;
  for (std::size_t i = 0; i < sources.size(); ++i)
    for (const auto& [symbol, part] : parts_from(sources[i].lines)) {
      const auto& source = sources[i];
      if (!has(data, rows[i], symbol)) continue;
      if (stated_by.try_emplace(symbol, &source).second) {
        parts.emplace_back(symbol, part);
        continue;
      }
      const auto first = std::ranges::find(parts, symbol, &Parts::value_type::first);
      if (first->second == part) continue;
      return fail(ErrorCode::invalid_argument, reasons::kMetadataDisagree,
                  name_of(*stated_by.at(symbol)) + " states the part " + symbol + "=" +
                      first->second + " and " + name_of(source) + " the part " + symbol + "=" +
                      part +
                      ": expected one part of each thermometer in all runs that are taken "
                      "together. Take them apart; or correct the line '# parts:' of one of the "
                      "files and import it again");
    }
  if (!parts.empty()) out.emplace_back(kPartsKey, parts_text(parts));
  return {};
}

// Counts that a file states are of its own rows: brought to those that are here.
void add_rows(MeasuredBy& coordinate, const MeasuredBy& of_source, std::size_t rows) {
  double stated_rows = 0;
  for (const auto& part : of_source.parts) stated_rows += part.rows;
  for (const auto& part : of_source.parts) {
    const double share =
        std::max(1.0, std::round(static_cast<double>(rows) * part.rows / stated_rows));
    const auto same = std::ranges::find(coordinate.parts, part.devices, &MeasuredRows::devices);
    if (same == coordinate.parts.end())
      coordinate.parts.push_back({part.devices, share});
    else
      same->rows += share;
  }
}

void add_instruments(const Dataset& data, std::span<const StatedLines> sources,
                     const RowsOfSources& rows, Lines& out) {
  std::vector<std::vector<MeasuredBy>> stated;
  std::vector<std::string> symbols;
  for (const auto& source : sources)
    for (const auto& coordinate : stated.emplace_back(measured_by_from(source.lines)))
      if (data.find(coordinate.symbol) != nullptr &&
          std::ranges::find(symbols, coordinate.symbol) == symbols.end())
        symbols.push_back(coordinate.symbol);
  std::vector<MeasuredBy> kept;
  Lines left_out;
  for (const auto& symbol : symbols) {
    MeasuredBy coordinate{symbol, {}};
    std::string silent;
    for (std::size_t i = 0; i < sources.size(); ++i) {
      if (!has(data, rows[i], symbol)) continue;
      if (const auto* of_source = find_measured_by(stated[i], symbol))
        add_rows(coordinate, *of_source, rows[i].size());
      else
        silent += (silent.empty() ? "" : " and ") + name_of(sources[i]);
    }
    if (silent.empty() && !coordinate.parts.empty())
      kept.push_back(std::move(coordinate));
    else if (!silent.empty())
      left_out.emplace_back(kLeftOutKey, "measured_by of " + symbol + ": not stated by " + silent);
  }
  if (!kept.empty()) out.emplace_back(kMeasuredByKey, measured_by_text(kept));
  out.insert(out.end(), left_out.begin(), left_out.end());
}

}  // namespace

Result<Lines> stated_together(const Dataset& data, std::span<const StatedLines> sources) {
  Lines out;
  if (sources.empty()) return out;
  const auto rows = rows_of(data, sources);
  DRIFTWISE_RETURN_IF_ERROR(add_overruns(sources, out));
  DRIFTWISE_RETURN_IF_ERROR(add_parts(data, sources, rows, out));
  add_instruments(data, sources, rows, out);
  return out;
}

}  // namespace driftwise
