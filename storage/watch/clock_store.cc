#include "storage/watch/clock_store.h"

namespace driftwise::storage {

Result<void> SqliteClockStore::add_clock(const ClockRecord& record) {
  return session_.write([&] {
    Query(session_.db,
          "INSERT INTO clock (from_ns, offset_ns, step_ns, boot, boot_ns, ahead_ns) VALUES (?, ?, "
          "?, ?, ?, ?)")
        .bind(record.from.utc_ns, record.offset.count(), record.step.count(), record.boot,
              record.boot_ns, record.ahead_ns)
        .run();
  });
}

Result<std::vector<ClockRecord>> SqliteClockStore::clocks() {
  return session_.read([&] {
    Query query(session_.db,
                "SELECT from_ns, offset_ns, step_ns, boot, boot_ns, ahead_ns FROM clock ORDER BY "
                "from_ns, clock_id");
    std::vector<ClockRecord> records;
    while (query.row())
      records.push_back({{query.integer(0)},
                         Nanoseconds(query.integer(1)),
                         Nanoseconds(query.integer(2)),
                         query.text(3),
                         query.integer(4),
                         query.integer(5)});
    return records;
  });
}

// The last rows only: a run that was imported has instants of its own choice, and no index leads to
// the largest of them.
Result<CellTime> SqliteClockStore::newest_instant() {
  return session_.read([&] {
    Query query(session_.db,
                "SELECT max(coalesce((SELECT at_ns FROM event ORDER BY event_id DESC LIMIT 1), 0), "
                "coalesce((SELECT end_ns FROM reading ORDER BY reading_id DESC LIMIT 1), 0), "
                "coalesce((SELECT max(from_ns) FROM clock), 0))");
    query.row();
    return CellTime{query.integer(0)};
  });
}

}  // namespace driftwise::storage
