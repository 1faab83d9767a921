#pragma once
// What happened to diagnoses and improvements, by cursor (storage/schema/schema_v5.h).

#include "server/core/records/watch_records.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

std::int64_t newest_job_change(Session& session);

// Fills page.diagnoses, page.improvements and page.to.job: those of at most limit changes after one
// cursor and up to the other, each once, as it is now.
void read_job_changes(Session& session, const RecordCursor& after, const RecordCursor& until,
                      int limit, RecordPage& page);

}  // namespace driftwise::storage
