#include "server/standards/measured_columns.h"

#include <set>

#include "server/core/reasons.h"
#include "server/core/unit_conversion.h"

namespace driftwise::standards {
namespace {

Result<std::vector<double>> converted_column(const Dataset& dataset, std::string_view symbol,
                                             const char* unit) {
  const auto* column = dataset.find(symbol);
  if (!column) {
    std::string list;
    for (const auto& each : dataset.columns) list += " " + each.channel.name();
    return fail(ErrorCode::invalid_argument, reasons::kNoColumn,
                "found no column '" + std::string(symbol) + "', found" + list);
  }
  const auto convert = unit_conversion(column->channel.unit, unit);
  if (!convert)
    return fail(ErrorCode::invalid_argument, reasons::kUnitKind,
                "column " + column->channel.name() + ": " + convert.error().message);
  std::vector<double> out;
  out.reserve(column->values.size());
  for (const double value : column->values) out.push_back((*convert)(value));
  return out;
}

}  // namespace

Result<std::vector<double>> column_mm(const Dataset& dataset, std::string_view symbol) {
  return converted_column(dataset, symbol, "mm");
}

Result<std::vector<double>> column_arcsec(const Dataset& dataset, std::string_view symbol) {
  return converted_column(dataset, symbol, "arcsec");
}

std::string first_present(const Dataset& dataset, const std::vector<std::string>& symbols) {
  for (const auto& symbol : symbols)
    if (dataset.find(symbol)) return symbol;
  return {};
}

std::size_t datum_count(const Dataset& dataset) {
  if (dataset.datum.empty()) return 1;
  std::set<std::int64_t> datums;
  for (std::size_t row = 0; row < dataset.rows; ++row)
    if (!dataset.is_excluded(row)) datums.insert(dataset.datum[row]);
  return datums.size();
}

TimeSpan time_span(const Dataset& dataset) {
  TimeSpan span;
  for (std::size_t row = 0; row < dataset.time_s.size(); ++row) {
    if (dataset.is_excluded(row)) continue;
    if (is_missing(span.first_s)) span.first_s = dataset.time_s[row];
    span.last_s = dataset.time_s[row];
  }
  return span;
}

}  // namespace driftwise::standards
