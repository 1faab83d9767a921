#include "server/application/serving/memory.h"

#include <algorithm>
#include <iterator>

#include "server/core/try.h"

namespace driftwise::application {
namespace {

const DeviceDescription* giver_of(const CellDescription& cell, const std::string& channel) {
  for (const auto& device : cell.devices)
    if (std::ranges::find(device.channels, channel, &Channel::name) != device.channels.end())
      return &device;
  return nullptr;
}

// An empty id stands for every device.
std::vector<std::string> givers_of(const CellDescription& cell,
                                   const std::vector<std::string>& channels) {
  std::vector<std::string> ids;
  for (const auto& channel : channels) {
    const auto* device = giver_of(cell, channel);
    if (!device) return {""};
    if (std::ranges::find(ids, device->id) == ids.end()) ids.push_back(device->id);
  }
  return ids;
}

// Both parts of [from, to).
Result<void> append_window(Store& store, const std::vector<std::string>& devices,
                           const MemoryQuery& query, CellTime from, CellTime to,
                           std::vector<Reading>& out) {
  const CellTime recent = std::max(from, to - kMemory);
  if (from < recent) {
    DRIFTWISE_TRY(auto means, means_for_memory(store, query.channels, from, recent, kMemoryMeans));
    std::ranges::move(means, std::back_inserter(out));
  }
  std::vector<Reading> whole;
  for (const auto& id : devices) {
    DRIFTWISE_TRY(auto found, store.readings().readings(id, recent, to, kMemoryReadings));
    std::ranges::move(found, std::back_inserter(whole));
  }
  std::ranges::stable_sort(whole, {}, &Reading::start);
  std::ranges::move(whole, std::back_inserter(out));
  return {};
}

}  // namespace

Result<std::vector<Reading>> means_for_memory(Store& store,
                                              const std::vector<std::string>& channels,
                                              CellTime from, CellTime to, int most) {
  std::vector<Reading> out;
  for (const auto& channel : channels) {
    DRIFTWISE_TRY(const auto series, store.series().series({{channel}, from, to, most, {}}));
    const auto& column = series.columns.front();
    for (std::size_t b = 0; b < column.count.size(); ++b) {
      const CellTime middle =
          series.from + series.bucket * static_cast<std::int64_t>(b) + series.bucket / 2;
      if (column.count[b] > 0 && from <= middle && middle < to)
        out.push_back({"", middle, middle, 0, {{channel, column.mean[b]}}});
    }
  }
  std::ranges::stable_sort(out, {}, &Reading::start);
  return out;
}

void append_latest(const Recorder& recorder, std::vector<Reading>& readings) {
  for (const auto& latest : recorder.history().latest())
    if (!is_missing(latest.value))
      readings.push_back({"", latest.at, latest.at, 0, {{latest.channel, latest.value}}});
  std::ranges::stable_sort(readings, {}, &Reading::middle);
}

Result<std::vector<Reading>> readings_for_memory(Store& store, const CellDescription& cell,
                                                 const MemoryQuery& query, CellTime now) {
  const Nanoseconds reach = std::max(kMemory, query.reach);
  const auto devices = givers_of(cell, query.channels);
  std::vector<Reading> out;
  CellTime from = now - reach;
  if (query.zero && *query.zero < now) {
    const CellTime after = *query.zero + Nanoseconds(1);  // the end of a window is left out
    DRIFTWISE_RETURN_IF_ERROR(
        append_window(store, devices, query, *query.zero - reach, after, out));
    from = std::max(from, after);
  }
  DRIFTWISE_RETURN_IF_ERROR(append_window(store, devices, query, from, now, out));
  return out;
}

}  // namespace driftwise::application
