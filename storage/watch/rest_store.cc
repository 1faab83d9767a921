#include "storage/watch/rest_store.h"

namespace driftwise::storage {

Result<std::int64_t> SqliteRestStore::begin_rest(const RestRecord& rest) {
  return session_.write([&] {
    Query(session_.db, "UPDATE rest SET ended_ns = ?, end_reason = 'begun anew' WHERE ended_ns = 0")
        .bind(rest.begin.utc_ns)
        .run();
    Query(session_.db,
          "INSERT INTO rest (begun_ns, ended_ns, begun_by, end_reason, length_nm_per_h, "
          "temperature_k_per_h, window_s) VALUES (?, 0, ?, '', ?, ?, ?)")
        .bind(rest.begin.utc_ns, rest.begun_by, rest.length_nm_per_h, rest.temperature_k_per_h,
              rest.window_s)
        .run();
    return session_.db.last_row_id();
  });
}

Result<void> SqliteRestStore::end_rest(std::int64_t id, CellTime at, const std::string& reason) {
  return session_.write([&] {
    Query(session_.db,
          "UPDATE rest SET ended_ns = ?, end_reason = ? WHERE rest_id = ? AND ended_ns = 0")
        .bind(at.utc_ns, reason, id)
        .run();
  });
}

Result<std::optional<RestRecord>> SqliteRestStore::newest_rest() {
  return session_.read([&]() -> std::optional<RestRecord> {
    Query query(session_.db,
                "SELECT rest_id, begun_ns, ended_ns, begun_by, end_reason, length_nm_per_h, "
                "temperature_k_per_h, window_s FROM rest ORDER BY rest_id DESC LIMIT 1");
    if (!query.row()) return std::nullopt;
    return RestRecord{query.integer(0), {query.integer(1)}, {query.integer(2)}, query.text(3),
                      query.text(4),    query.real(5),      query.real(6),      query.real(7)};
  });
}

}  // namespace driftwise::storage
