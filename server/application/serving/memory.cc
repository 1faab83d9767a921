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

}  // namespace

Result<std::vector<Reading>> readings_for_memory(Store& store, const CellDescription& cell,
                                                 const std::vector<std::string>& channels,
                                                 CellTime now) {
  std::vector<Reading> out;
  for (const auto& id : givers_of(cell, channels)) {
    DRIFTWISE_TRY(auto found, store.readings().readings(id, now - kMemory, now, kMemoryReadings));
    out.insert(out.end(), std::make_move_iterator(found.begin()),
               std::make_move_iterator(found.end()));
  }
  std::ranges::stable_sort(out, {}, &Reading::start);
  return out;
}

}  // namespace driftwise::application
