#include "server/correction/data_amendment.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "server/core/try.h"
#include "server/core/units.h"
#include "server/effects/term_evaluator.h"
#include "server/effects/term_order.h"

namespace driftwise::correction {
namespace {

using DatumKey = std::pair<std::int64_t, std::int64_t>;  // run, datum

DatumKey datum_key(const Dataset& dataset, const std::vector<RowOrigin>& origins, std::size_t row) {
  return {origins[row].run.value, dataset.datum.empty() ? 0 : dataset.datum[row]};
}

const std::vector<double>& weights_of(const LengthShift& shift) { return shift.mm; }
const std::vector<double>& weights_of(const AngleShift& shift) { return shift.arcsec; }

template <class Shift>
std::vector<std::string> symbols_read(const Shift& shift) {
  std::vector<std::string> symbols;
  for (const auto& term : shift.terms)
    for (const auto& symbol : effects::symbols_of(term))
      if (std::ranges::find(symbols, symbol) == symbols.end()) symbols.push_back(symbol);
  return symbols;
}

double weighted(const std::vector<double>& columns, const std::vector<double>& weights) {
  double sum = 0;
  for (std::size_t j = 0; j < columns.size(); ++j) sum += columns[j] * weights[j];
  return sum;
}

template <class Shift>
bool holds_for(const Shift& shift, const RowOrigin& origin) {
  return shift.runs.empty() ? !origin.of_file
                            : std::ranges::find(shift.runs, origin.run) != shift.runs.end();
}

// Of the dataset's time_s against the clock that the shift's terms read.
template <class Shift>
double clock_offset_s(const Shift& shift, CellTime time_zero) {
  if (time_zero.utc_ns == 0 || shift.clock_origin.utc_ns == 0) return 0;
  return seconds_from(time_zero - shift.clock_origin);
}

// mm or arcsec per row; nothing: a channel is not there at all.
template <class Shift>
Result<std::optional<std::vector<double>>> shift_by_row(const Shift& shift,
                                                        const std::vector<RowOrigin>& origins,
                                                        CellTime time_zero,
                                                        const Dataset& dataset) {
  using Rows = std::optional<std::vector<double>>;
  const auto symbols = symbols_read(shift);
  std::vector<std::span<const double>> values;
  for (const auto& symbol : symbols) {
    values.push_back(dataset.values_of(symbol));
    if (values.back().empty()) return Rows();
  }
  DRIFTWISE_TRY(auto evaluator, effects::TermEvaluator::create(shift.terms, symbols));
  if (evaluator.has_memory() && dataset.time_s.empty()) return Rows();
  std::vector<double> now(symbols.size()), zero(symbols.size()), columns(shift.terms.size());
  const double offset_s = clock_offset_s(shift, time_zero);
  std::map<DatumKey, double> at_zero;
  std::vector<double> by_row(dataset.rows, 0.0);
  for (std::size_t row = 0; row < dataset.rows; ++row) {
    if (!holds_for(shift, origins[row])) continue;
    const double time_s = dataset.time_s.empty() ? 0.0 : dataset.time_s[row] + offset_s;
    for (std::size_t j = 0; j < symbols.size(); ++j) {
      now[j] = values[j][row];
      zero[j] = is_pose_symbol(without_robot(symbols[j])) ? 0.0 : now[j];
    }
    const auto key = datum_key(dataset, origins, row);
    auto begin = at_zero.find(key);
    if (begin == at_zero.end()) {
      auto fork = evaluator;
      fork.step(time_s, zero, columns);
      const double there = weighted(columns, weights_of(shift));
      // A datum whose first rows lack a reading counts from the first that has it; until then
      // nothing can be taken off.
      if (std::isfinite(there)) begin = at_zero.emplace(key, there).first;
    }
    evaluator.step(time_s, now, columns);
    by_row[row] =
        begin == at_zero.end() ? kMissing : weighted(columns, weights_of(shift)) - begin->second;
  }
  return Rows(std::move(by_row));
}

void split_datums(const DataAmendment& amendment, const std::vector<RowOrigin>& origins,
                  Dataset& dataset) {
  for (const auto& split : amendment.splits) {
    const auto first = std::ranges::find_if(origins, [&](const RowOrigin& origin) {
      return origin.run == split.run && origin.row == split.row;
    });
    if (first == origins.end()) continue;
    if (dataset.datum.empty()) dataset.datum.assign(dataset.rows, 0);
    const auto from = static_cast<std::size_t>(first - origins.begin());
    const std::int64_t old = dataset.datum[from];
    // Not a number that any other datum has: those of the record are positive.
    const std::int64_t fresh =
        std::min<std::int64_t>(0, *std::ranges::min_element(dataset.datum)) - 1;
    for (std::size_t row = from; row < dataset.rows; ++row)
      if (origins[row].run == split.run && dataset.datum[row] == old) dataset.datum[row] = fresh;
  }
}

}  // namespace

Result<void> amend(const DataAmendment& amendment, const std::vector<RowOrigin>& origins,
                   CellTime time_zero, Dataset& dataset) {
  if (dataset.rows == 0) return {};
  split_datums(amendment, origins, dataset);
  for (const auto& left_out : amendment.sensors)
    if (std::ranges::find(origins, left_out.run, &RowOrigin::run) != origins.end())
      std::erase_if(dataset.columns, [&](const DatasetColumn& column) {
        return column.channel.symbol == left_out.symbol;
      });
  // All shifts from what was measured, then all columns: none sees another's.
  std::vector<std::pair<std::size_t, std::vector<double>>> found, turned;
  for (const auto& shift : amendment.shifts) {
    const auto* column = dataset.find(shift.axis);
    if (column == nullptr || !is_length(column->channel.unit)) continue;
    DRIFTWISE_TRY(auto mm, shift_by_row(shift, origins, time_zero, dataset));
    if (mm)
      found.emplace_back(static_cast<std::size_t>(column - dataset.columns.data()), std::move(*mm));
  }
  for (const auto& shift : amendment.angles) {
    const auto* column = dataset.find(shift.axis);
    if (column == nullptr || !is_angle(column->channel.unit)) continue;
    DRIFTWISE_TRY(auto arcsec, shift_by_row(shift, origins, time_zero, dataset));
    if (!arcsec) continue;
    const double arcsec_per_unit = summary_unit(column->channel.unit).factor;
    for (double& value : *arcsec) value /= arcsec_per_unit;
    turned.emplace_back(static_cast<std::size_t>(column - dataset.columns.data()),
                        std::move(*arcsec));
  }
  for (const auto& [index, mm] : found) {
    auto& column = dataset.columns[index];
    const double mm_per_unit = mm_from_nm(summary_unit(column.channel.unit).factor);
    for (std::size_t row = 0; row < dataset.rows; ++row)
      column.values[row] -= mm[row] / mm_per_unit;
  }
  for (const auto& [index, by_row] : turned)
    for (std::size_t row = 0; row < dataset.rows; ++row)
      dataset.columns[index].values[row] -= by_row[row];
  return {};
}

}  // namespace driftwise::correction
