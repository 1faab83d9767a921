#pragma once
// Which instruments measured the coordinates of runs, and which corrections hold for them. Called
// on the store's thread.

#include <map>
#include <span>
#include <string>
#include <vector>

#include "server/core/ports/store.h"
#include "server/core/records/records.h"
#include "server/correction/data_amendment.h"

namespace driftwise::application {

// Ids of the devices by symbol ("ma.z"), as in the run's cell file: those of its set-up; without
// one, the device that declares the length. Of a joined run those of its sources. A coordinate that
// is not there: not known.
using Instruments = std::map<std::string, std::vector<std::string>>;
// Errors: those of RunStore.
Result<Instruments> instruments_of(Store& store, const RunRecord& run);
// Of all of these runs together. A coordinate that is not known of one of them is left out.
Result<Instruments> instruments_of(Store& store, std::span<const RunId> runs);

// The amendment for these runs: a shift of a device is confined to those whose axis that device
// measured, or may have (not known, and not a file's); with none of them it is left out. Errors:
// those of RunStore.
Result<correction::DataAmendment> held_for(Store& store, correction::DataAmendment amendment,
                                           std::span<const RunId> runs);

}  // namespace driftwise::application
