#include "storage/audit/audit_store.h"

#include "server/core/reasons.h"
#include "server/digest/sha256.h"
#include "storage/audit/record_copy.h"
#include "storage/chain/chain_check.h"
#include "storage/readings/thinning.h"
#include "storage/watch/event_store.h"

namespace driftwise::storage {
namespace {

AuditRecord act_from(const Query& row) {
  AuditRecord act;
  act.id = row.integer(0);
  act.at = {{row.integer(1)}, row.integer(2)};
  act.by = {row.text(3), row.text(4), row.text(5)};
  act.what = row.text(6);
  act.subject = row.text(7);
  act.before = row.text(8);
  act.after = row.text(9);
  act.outcome = row.text(10);
  act.event = {row.integer(11)};
  return act;
}

}  // namespace

Result<AuditRecord> SqliteAuditStore::add(const AuditRecord& act,
                                          const std::optional<EventRecord>& event) {
  return session_.write([&] {
    AuditRecord stored = act;
    stored.event = event ? insert_event(session_, *event) : EventId{};
    // An act without an event has the id 0, which no event has.
    Query(session_.db,
          "INSERT INTO audit (at_ns, at_monotonic_ns, who, proof, peer, what, subject, "
          "before_value, after_value, outcome, event_id) "
          "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, NULLIF(?, 0))")
        .bind(act.at.utc.utc_ns, act.at.monotonic_ns, act.by.name, act.by.proof, act.by.from,
              act.what, act.subject, act.before, act.after, act.outcome, stored.event)
        .run();
    stored.id = session_.db.last_row_id();
    return stored;
  });
}

Result<std::vector<AuditRecord>> SqliteAuditStore::acts(std::int64_t before_id, int limit) {
  return session_.read([&] {
    Query query(session_.db,
                "SELECT audit_id, at_ns, at_monotonic_ns, who, proof, peer, what, subject, "
                "before_value, after_value, outcome, event_id FROM audit WHERE ?1 <= 0 OR "
                "audit_id < ?1 ORDER BY audit_id DESC LIMIT ?2");
    query.bind(before_id, limit > 0 ? limit : -1);
    std::vector<AuditRecord> acts;
    while (query.row()) acts.push_back(act_from(query));
    return acts;
  });
}

Result<ChainHead> SqliteAuditStore::head() {
  return session_.read([&] {
    const ChainEntry newest = newest_entry(session_.db);
    return newest.number == 0 ? ChainHead{}
                              : ChainHead{newest.number, digest::hex_from(newest.head)};
  });
}

Result<ChainReport> SqliteAuditStore::verify(const std::optional<ChainHead>& outside,
                                             const std::function<bool()>& give_way) {
  return answered([&] {
    if (!tables_) tables_.emplace(session_.db);
    ChainCheck check(session_.db, *tables_, outside);
    while (check.step())
      if (give_way && give_way())
        throw_failure(ErrorCode::cancelled, reasons::kGaveWay,
                      "the check of the chain gave way: ask again");
    return check.report();
  });
}

std::string SqliteAuditStore::record_in(const std::string& path) {
  return identity_of_record(path);
}

Result<RecordCopy> SqliteAuditStore::back_up(const std::string& path,
                                             const std::function<bool()>& give_way) {
  return answered([&] { return copy_record(session_.db, path, give_way); });
}

Result<ThinningStep> SqliteAuditStore::thin(const ThinningOrder& order) {
  return session_.write([&] { return thin_readings(session_, order, kept_); });
}

}  // namespace driftwise::storage
