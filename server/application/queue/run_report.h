#pragma once
// Report of a run of the queue, as a file of plain text beside the database.

#include <functional>
#include <string>

#include "server/core/records/closure_records.h"
#include "server/core/records/queue_records.h"
#include "server/core/records/records.h"
#include "server/core/result.h"

namespace driftwise::application {

// A line per fact: the run, its metadata, the entry's terms, what has followed so far.
// closures: returns to zero of the run; those beyond their limits are named.
std::string run_report(const QueueEntry& entry, const RunRecord& run,
                       const std::vector<ClosureRecord>& closures,
                       const std::function<UtcTime(CellTime)>& utc);

// "cell.db" -> "reports/queue-4-run-12.txt" in the same folder.
std::string report_path(const std::string& database, QueueEntryId entry, RunId run);

// Under its name whole, or not at all; makes the folder. Blocks. Errors: internal CANNOT_WRITE.
Result<void> write_report(const std::string& path, const std::string& text);

}  // namespace driftwise::application
