#include "server/application/improvement/plan_rows.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/core/data/dataset_parts.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/diagnosis/rows_needed.h"
#include "server/formats/formula/formula.h"

namespace driftwise::application {
namespace {

// One row of everything that a point of this cell has: enough to expand a formula.
Dataset declared_channels(const CellDescription& cell) {
  Dataset data;
  data.rows = 1;
  Parts parts;
  const auto add = [&data](const Channel& channel) {
    if (data.find(channel.symbol) == nullptr) data.columns.push_back({channel, {0.0}});
  };
  for (const auto& channel : cell.motor_channels()) add(channel);
  for (const auto& channel : cell.length_channels()) add(channel);
  for (const auto& channel : cell.path_channels()) add(channel);
  for (const auto& channel : cell.angle_channels()) add(channel);
  if (const auto force = cell.force_channel()) add(*force);
  for (const auto& channel : cell.temperature_channels()) add(channel);
  for (const auto& device : cell.devices) {
    for (const auto& probe : device.probes()) parts.emplace_back(probe.channel.symbol, probe.part);
    if (device.length())
      for (const char* name : {"air_degC", "pressure_hPa", "humidity_pct"})
        add(*parse_channel(name));
  }
  data.metadata.emplace_back(kPartsKey, parts_text(parts));
  return data;
}

}  // namespace

Result<void> check_plan_rows(const CellDescription& cell, const Trajectory& plan,
                             const std::string& text) {
  DRIFTWISE_TRY(const auto formula, formats::Formula::parse(text));
  const auto candidates = formula.expand(declared_channels(cell));
  if (!candidates) return {};
  const auto of = [&plan](PointSet set) {
    return static_cast<std::size_t>(std::ranges::count(plan.points, set, &TrajectoryPoint::set));
  };
  const std::size_t validation = of(PointSet::validation);
  std::size_t rows = of(PointSet::calibration);
  std::string held_out;
  if (validation == 0) {
    held_out = fmt::format(" (a fifth of its {} is held out)", rows);
    rows -= rows / 5;
  } else if (rows == 0) {  // nothing to learn from but the validation rows
    rows = validation;
  }
  const std::size_t terms = candidates->terms.size() + 1;  // the constant
  const std::size_t needed = terms + diagnosis::kRowsBeyondBase;
  if (rows >= needed) return {};
  return fail(
      ErrorCode::invalid_argument, reasons::kTooFewRows,
      fmt::format("the plan has {} rows to learn from{}; {} has {} terms, and a diagnosis of "
                  "it needs {} rows at least: nothing was moved. Measure more positions, or "
                  "offer fewer terms",
                  rows, held_out, text, terms, needed));
}

}  // namespace driftwise::application
