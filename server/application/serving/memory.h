#pragma once
// Readings that bring the effects with memory of a model up to date when it begins to serve.

#include <string>
#include <vector>

#include "server/core/description/cell_description.h"
#include "server/core/ports/store.h"

namespace driftwise::application {

inline constexpr Nanoseconds kMemory = std::chrono::hours(6);  // above any lag of the catalogue
inline constexpr int kMemoryReadings = 50'000;

// Readings of the six hours before now, oldest first, of the devices that give one of the channels
// (full names); of every device where the cell file names none for a channel. Of each device at
// most the newest kMemoryReadings. Blocks: on the store's thread. Errors: those of the store.
Result<std::vector<Reading>> readings_for_memory(Store& store, const CellDescription& cell,
                                                 const std::vector<std::string>& channels,
                                                 CellTime now);

}  // namespace driftwise::application
