#include "server/standards/conditions.h"

#include <algorithm>

#include "server/core/unit_conversion.h"

namespace driftwise::standards {

Conditions conditions_of(const Dataset& dataset) {
  Conditions out;
  if (!dataset.time_s.empty()) out.duration_s = dataset.time_s.back() - dataset.time_s.front();
  for (const auto& column : dataset.columns) {
    const std::string& unit = column.channel.unit;
    if (unit != "degC" && unit != "K") continue;
    const auto to_degc = *unit_conversion(unit, "degC");
    TemperatureRange range{column.channel.name()};
    for (const double value : column.values) {
      if (is_missing(value)) continue;
      const double degc = to_degc(value);
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
