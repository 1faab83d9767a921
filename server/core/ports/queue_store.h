#pragma once
// The queue of campaigns, and what people say of runs by keys: parts of server/core/ports/store.h,
// with its thread and its errors.

#include <string>
#include <vector>

#include "server/core/records/queue_records.h"
#include "server/core/records/records.h"
#include "server/core/result.h"

namespace driftwise {

class QueueStore {
 public:
  virtual ~QueueStore() = default;
  // Every entry that is not over, those they wait for, and the newest `history` of all.
  virtual Result<QueueRecord> queue(int history) = 0;
  // In one transaction, durable when it returns. RunStore::create_run of a run with an entry puts
  // that entry into state running, and a stop (StopStore::keep) holds the queue, each in the
  // transaction of its own.
  virtual Result<void> change_queue(const QueueChange& change) = 0;
};

class MetadataStore {
 public:
  virtual ~MetadataStore() = default;
  // Errors: not_found NO_SUCH_RUN.
  virtual Result<RunRecord> tag(RunId run, const RunMetadata& set,
                                const std::vector<std::string>& removed) = 0;
  // Runs that have all of these, newest first; none given: every run. As RunStore::runs().
  virtual Result<std::vector<RunRecord>> find_runs(const RunMetadata& all_of, int limit,
                                                   std::int64_t before_id /* 0: newest */) = 0;
};

}  // namespace driftwise
