#pragma once
// Acts of people, the chain over the record, and its copies: part of server/core/ports/store.h,
// with its threads and errors. What the chain protects: docs/database.md.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "server/core/records/audit_records.h"
#include "server/core/records/copy_records.h"
#include "server/core/records/records.h"
#include "server/core/records/thinning_records.h"
#include "server/core/result.h"

namespace driftwise {

class AuditStore {
 public:
  virtual ~AuditStore() = default;
  // In one transaction: the act and, where there is one, the event that tells of it. Ids are
  // ignored. Result: the act as stored.
  virtual Result<AuditRecord> add(const AuditRecord& act,
                                  const std::optional<EventRecord>& event) = 0;
  // Newest first, those before an id (0: from the newest).
  virtual Result<std::vector<AuditRecord>> acts(std::int64_t before_id, int limit) = 0;
  virtual Result<ChainHead> head() = 0;
  // The whole record against its chain, and the chain against a head that was kept elsewhere.
  // Reads everything: minutes for a record of weeks; the view of the database is let go of and
  // taken anew every few thousand rows. give_way is asked every now and then; when it says true the
  // check ends with cancelled GAVE_WAY.
  virtual Result<ChainReport> verify(const std::optional<ChainHead>& outside,
                                     const std::function<bool()>& give_way) = 0;
  // One view of the record into a new file, verified: pages, rows of every table, head of the
  // chain. Errors: already_exists FILE_EXISTS, cancelled GAVE_WAY, those of the disk.
  virtual Result<RecordCopy> back_up(const std::string& path,
                                     const std::function<bool()>& give_way) = 0;
  // Of the record in a file, as RecordStore::database_id(); empty: it cannot be told.
  virtual std::string record_in(const std::string& path) = 0;
  // One step of thinning, in one transaction with its entry of the chain: of the next few thousand
  // readings, those of the environment that no attempt, point or rejected value refers to become
  // one row per device and interval. Errors: invalid_argument BAD_REDUCER, BAD_RANGE.
  virtual Result<ThinningStep> thin(const ThinningOrder& order) = 0;
};

}  // namespace driftwise
