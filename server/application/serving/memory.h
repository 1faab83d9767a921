#pragma once
// Readings that bring the effects with memory of a model up to date when it begins to serve, and to
// the zero of the datum that it serves in.

#include <optional>
#include <string>
#include <vector>

#include "server/application/recording/recorder.h"
#include "server/core/description/cell_description.h"
#include "server/core/ports/store.h"
#include "server/core/records/records.h"

namespace driftwise::application {

inline constexpr Nanoseconds kMemory = std::chrono::hours(6);  // read back in any case
inline constexpr int kMemoryReadings = 50'000;
inline constexpr int kMemoryMeans = 5'000;

struct MemoryQuery {
  std::vector<std::string> channels;  // full names
  Nanoseconds reach = kMemory;        // at least kMemory is read (SnapshotBuilder::memory)
  std::optional<CellTime> zero = {};  // of the datum to be anchored; none: only now counts
};

// Readings before now, oldest first, of the devices that give one of the channels; of every device
// where the cell file names none for a channel.
// - The last six hours: every reading, of each device at most the newest kMemoryReadings.
// - From there to `reach` before now: means of the channels, kMemoryMeans at most. A square_lag of
//   a channel that fluctuates within such a mean (1/500 of the time constant) comes out too small.
// - With a zero before now: the same two parts before the zero as well. A time between them that
//   neither reaches is left out.
// Blocks: on the store's thread. Errors: those of the store.
Result<std::vector<Reading>> readings_for_memory(Store& store, const CellDescription& cell,
                                                 const MemoryQuery& query, CellTime now);

// Means of the channels in [from, to), oldest first, as readings in the middle of their times; a
// channel that was never recorded gives none. Blocks. Errors: those of the store.
Result<std::vector<Reading>> means_for_memory(Store& store,
                                              const std::vector<std::string>& channels,
                                              CellTime from, CellTime to, int most);

// Instant of a datum's zero.
inline std::optional<CellTime> zero_of(const std::optional<DatumRecord>& datum) {
  return datum ? std::optional(datum->opened.utc) : std::nullopt;
}

// Values that have not reached the disk yet: the recorder's latest ones are added, and the whole
// is put in order of time.
void append_latest(const Recorder& recorder, std::vector<Reading>& readings);

// Feeds readings, oldest first, to a builder (SnapshotBuilder, plans::JointBuilder). anchor() is
// called once: after the readings up to the zero and before the others.
template <class Builder, class Anchor>
void replay(const std::vector<Reading>& readings, std::optional<CellTime> zero, Builder& builder,
            Anchor anchor) {
  bool anchored = false;
  for (const auto& reading : readings) {
    if (!anchored && zero && reading.middle() > *zero) {
      anchor();
      anchored = true;
    }
    builder.observe(reading);
  }
  if (!anchored) anchor();
}

}  // namespace driftwise::application
