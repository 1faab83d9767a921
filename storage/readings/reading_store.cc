#include "storage/readings/reading_store.h"

#include <algorithm>

#include "storage/readings/thinning.h"
#include "storage/rows/reading_rows.h"

namespace driftwise::storage {
namespace {

// Of more than limit the newest, oldest first.
void read_device(Session& session, std::int64_t device_id, CellTime from, CellTime to, int limit,
                 std::vector<Reading>& into) {
  Query query(session.db,
              "SELECT reading_id, start_ns, end_ns, sequence FROM reading WHERE device_id = ? AND "
              "start_ns >= ? AND "
              "start_ns < ? ORDER BY start_ns DESC, reading_id DESC LIMIT ?");
  Query values(
      session.db,
      "SELECT channel_id, CASE WHEN EXISTS (SELECT 1 FROM rejected_value x WHERE x.device_id = ?2 "
      "AND x.start_ns = ?3 AND x.sequence = ?4 AND x.channel_id = v.channel_id) THEN NULL ELSE "
      "value END FROM reading_value v WHERE reading_id = ?1 ORDER BY channel_id");
  const auto first = std::ssize(into);
  query.bind(device_id, from.utc_ns, to.utc_ns, limit > 0 ? limit : -1);
  while (query.row()) {
    Reading reading{session.names.device_name(device_id),
                    {query.integer(1)},
                    {query.integer(2)},
                    query.integer(3),
                    {}};
    values.bind(query.integer(0), device_id, query.integer(1), query.integer(3));
    while (values.row())
      reading.values.push_back({session.names.channel_name(values.integer(0)), values.real(1)});
    values.restart();
    into.push_back(std::move(reading));
  }
  std::reverse(into.begin() + first, into.end());
}

// from and to may name different numbers of axes; the shorter one has been filled up.
void drop_missing_tail(std::vector<double>& mm) {
  while (!mm.empty() && is_missing(mm.back())) mm.pop_back();
}

}  // namespace

Result<void> SqliteReadingStore::append(std::span<const Reading> readings,
                                        std::span<const MoveRecord> moves,
                                        std::span<const RejectedAnswer> rejected) {
  return session_.write([&] {
    insert_readings(session_, readings, std::nullopt);
    insert_moves(session_, moves);
    insert_rejected(session_, rejected);
  });
}

Result<std::vector<Reading>> SqliteReadingStore::readings(const std::string& device, CellTime from,
                                                          CellTime to, int limit) {
  return session_.read([&] {
    // The index is by device, then time: with every device asked for, each gives its own series and
    // they are merged.
    std::vector<Reading> found;
    for (const auto& [id, name] : session_.names.devices())
      if (device.empty() || name == device) {
        read_device(session_, id, from, to, limit, found);
        read_thinned(session_, id, from, to, limit, found);
      }
    std::ranges::stable_sort(found, {}, &Reading::start);
    if (limit > 0 && std::ssize(found) > limit) found.erase(found.begin(), found.end() - limit);
    return found;
  });
}

Result<std::vector<MoveRecord>> SqliteReadingStore::moves(CellTime from, CellTime to) {
  return session_.read([&] {
    Query query(
        session_.db,
        "SELECT at_ns, ordinal, axis, at_monotonic_ns, run_id, from_mm, to_mm, cause FROM move "
        "WHERE at_ns >= ? AND at_ns < ? ORDER BY at_ns, ordinal, axis");
    query.bind(from.utc_ns, to.utc_ns);
    std::vector<MoveRecord> moves;
    while (query.row()) {
      if (query.integer(2) <= 1) {  // the first axis begins a move
        MoveRecord move;
        if (const auto run = query.optional_integer(4)) move.run = RunId{*run};
        move.at = {{query.integer(0)}, query.integer(3)};
        move.cause = query.text(7);
        moves.push_back(std::move(move));
      }
      if (query.integer(2) == 0) continue;
      moves.back().from_mm.push_back(query.real(5));
      moves.back().to_mm.push_back(query.real(6));
    }
    for (MoveRecord& move : moves) {
      drop_missing_tail(move.from_mm);
      drop_missing_tail(move.to_mm);
    }
    return moves;
  });
}

}  // namespace driftwise::storage
