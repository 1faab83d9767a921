#include "server/application/commissioning/recorded_series.h"

#include "server/core/try.h"

namespace driftwise::application {

Result<std::vector<RecordedSeries>> recorded_series(Store& store, const std::string& device,
                                                    const std::vector<std::string>& channels,
                                                    CellTime from, CellTime to) {
  DRIFTWISE_TRY(const auto readings, store.readings().readings(device, from, to, kMostReadings));
  std::vector<RecordedSeries> out;
  for (const auto& channel : channels) out.push_back({channel, {}});
  for (const auto& reading : readings) {
    const double time_s = seconds_from(reading.middle() - from);
    for (auto& one : out) {
      const double* value = reading.find(one.channel);
      if (value == nullptr || is_missing(*value)) continue;
      // Clocks of two sources may overlap by a reading: time never steps back here.
      if (!one.samples.time_s.empty() && time_s <= one.samples.time_s.back()) continue;
      one.samples.time_s.push_back(time_s);
      one.samples.values.push_back(*value);
    }
  }
  return out;
}

}  // namespace driftwise::application
