#include "server/standards/conditions.h"

#include <algorithm>

#include "server/core/unit_conversion.h"
#include "server/standards/measured_columns.h"

namespace driftwise::standards {

Conditions conditions_of(const Dataset& dataset) {
  Conditions out;
  const auto span = time_span(dataset);
  out.duration_s = span.last_s - span.first_s;
  for (const auto& column : dataset.columns) {
    const std::string& unit = column.channel.unit;
    if (unit != "degC" && unit != "K") continue;
    const auto to_degc = *unit_conversion(unit, "degC");
    TemperatureRange range{column.channel.name()};
    for (std::size_t row = 0; row < dataset.rows; ++row) {
      if (dataset.is_excluded(row) || is_missing(column.values[row])) continue;
      const double degc = to_degc(column.values[row]);
      if (is_missing(range.first_degc)) {
        range.first_degc = range.min_degc = range.max_degc = degc;
      }
      range.last_degc = degc;
      range.min_degc = std::min(range.min_degc, degc);
      range.max_degc = std::max(range.max_degc, degc);
    }
    if (!is_missing(range.first_degc)) out.temperatures.push_back(range);
  }
  return out;
}

}  // namespace driftwise::standards
