#include "server/application/datasets/declared_channels.h"

#include <fmt/format.h>

#include "server/core/data/dataset_parts.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/formula/formula.h"

namespace driftwise::application {

Dataset declared_channels(const CellDescription& cell) {
  Dataset data;
  data.rows = 1;
  Parts parts;
  const auto add = [&data](const Channel& channel) {
    if (data.find(channel.symbol) == nullptr) data.columns.push_back({channel, {0.0}});
  };
  for (const auto& channel : cell.motor_channels()) {
    add(channel);
    add({channel.symbol + "_cmd", channel.unit});
  }
  for (const auto& channel : cell.length_channels()) {
    add(channel);
    add({channel.symbol + "_std", channel.unit});
  }
  for (const auto& channel : cell.path_channels()) add(channel);
  for (const auto& channel : cell.angle_channels()) add(channel);
  if (const auto force = cell.force_channel()) add(*force);
  for (const auto& channel : cell.temperature_channels()) add(channel);
  for (const auto& device : cell.devices) {
    for (const auto& probe : device.probes()) parts.emplace_back(probe.channel.symbol, probe.part);
    for (const auto& channel : device.channels) add(channel);
  }
  data.metadata.emplace_back(kPartsKey, parts_text(parts));
  return data;
}

Result<void> check_formula_reads(const CellDescription& cell, const std::string& text) {
  DRIFTWISE_TRY(const auto formula, formats::Formula::parse(text));
  auto candidates = formula.expand(declared_channels(cell));
  if (candidates) return {};
  Error error = std::move(candidates.error());
  error.message = fmt::format("{}: {}; nothing was moved", text, error.message);
  return tl::unexpected(std::move(error));
}

}  // namespace driftwise::application
