#include "storage/indentation/indentation_store.h"

#include "server/core/reasons.h"

namespace driftwise::storage {
namespace {

constexpr const char* kOneIndentation =
    "SELECT indentation_id, key, file_text, record_json, ended, microscope_csv, created_ns, "
    "reported_ns, created_by, created_from FROM indentation WHERE indentation_id = ?";
constexpr const char* kNewestIndentations =
    "SELECT indentation_id, key, file_text, record_json, ended, microscope_csv, created_ns, "
    "reported_ns, created_by, created_from FROM indentation ORDER BY indentation_id DESC LIMIT ?";

IndentationRecord indentation_from(Query& row) {
  IndentationRecord record;
  record.id = {row.integer(0)};
  record.key = row.text(1);
  record.file_text = row.text(2);
  record.record_json = row.text(3);
  record.ended = row.text(4);
  record.microscope_csv = row.text(5);
  record.created = {row.integer(6)};
  record.reported = {row.integer(7)};
  record.created_by = row.text(8);
  record.created_from = row.text(9);
  return record;
}

IndentationRecord read_indentation(Session& session, IndentationId id) {
  Query query(session.db, kOneIndentation);
  if (!query.bind(id.value).row())
    throw_failure(ErrorCode::not_found, reasons::kNoSuchRecord,
                  "there is no indentation " + std::to_string(id.value) +
                      ": 'driftwise indent list' shows those there are");
  return indentation_from(query);
}

}  // namespace

Result<IndentationRecord> SqliteIndentationStore::add_indentation(const IndentationRecord& record) {
  return session_.write([&] {
    Query same(session_.db, "SELECT indentation_id FROM indentation WHERE key = ?");
    if (same.bind(record.key).row()) return read_indentation(session_, {same.integer(0)});
    Query(session_.db,
          "INSERT INTO indentation (key, file_text, record_json, ended, microscope_csv, "
          "created_ns, reported_ns, created_by, created_from) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)")
        .bind(record.key, record.file_text, record.record_json, record.ended, record.microscope_csv,
              record.created.utc_ns, record.reported.utc_ns, record.created_by, record.created_from)
        .run();
    return read_indentation(session_, {session_.db.last_row_id()});
  });
}

Result<void> SqliteIndentationStore::change_indentation(const IndentationRecord& record) {
  return session_.write([&] {
    read_indentation(session_, record.id);
    Query(session_.db,
          "UPDATE indentation SET file_text = ?, record_json = ?, ended = ?, microscope_csv = ?, "
          "reported_ns = ? WHERE indentation_id = ?")
        .bind(record.file_text, record.record_json, record.ended, record.microscope_csv,
              record.reported.utc_ns, record.id.value)
        .run();
  });
}

Result<IndentationRecord> SqliteIndentationStore::indentation(IndentationId id) {
  return session_.read([&] { return read_indentation(session_, id); });
}

Result<std::vector<IndentationRecord>> SqliteIndentationStore::indentations(int limit) {
  return session_.read([&] {
    Query query(session_.db, kNewestIndentations);
    query.bind(limit);
    std::vector<IndentationRecord> records;
    while (query.row()) records.push_back(indentation_from(query));
    return records;
  });
}

}  // namespace driftwise::storage
