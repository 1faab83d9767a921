#pragma once
// What an accepted correction does to lengths that are in the record. Called on the store's thread.

#include <vector>

#include "server/core/ports/clock.h"
#include "server/core/ports/store.h"
#include "server/core/records/configuration_records.h"
#include "server/correction/data_amendment.h"

namespace driftwise::application {

// Of one run: its data with everything that is in force, against the same with the amendment's
// shifts on top. One entry per length that changes by 0.1 nm or more in some row. Errors: those of
// amended_data and correction::amend.
Result<std::vector<LengthChange>> length_changes(Store& store, RunId run,
                                                 const correction::DataAmendment& amendment);

// Runs whose data an amendment can change: every one that the cell measured, or those that it
// names. The device of a shift is not looked at: ask about what held_for gives.
bool concerns(const correction::DataAmendment& amendment, const RunRecord& run);
bool concerns_every_run(const correction::DataAmendment& amendment);

// "x_mm of run 3 'weekend' by up to 3219 nm (rms 812 nm) in 200 rows, from 2026-11-20T08:12:00Z".
// clock: for the instant's UTC.
std::string sentence(const LengthChange& change, const Clock& clock);

}  // namespace driftwise::application
