#include "storage/watch/remark_store.h"

#include <map>

#include "server/core/reasons.h"
#include "storage/models/model_store.h"
#include "storage/rows/run_rows.h"

namespace driftwise::storage {
namespace {

void require_point(Session& session, RunId run, std::int64_t row) {
  Query query(session.db, "SELECT 1 FROM point WHERE run_id = ? AND trajectory_row = ?");
  if (!query.bind(run.value, row).row())
    throw_failure(ErrorCode::invalid_argument, reasons::kNoSuchRow,
                  "run " + std::to_string(run.value) + " has no accepted point in row " +
                      std::to_string(row + 1) + ": 'driftwise run points " +
                      std::to_string(run.value) + "' shows the rows there are");
}

// A person takes rows out by their numbers in the plan. A passage is counted after the plan's last
// row, so that a number that is too large by a few would take one out and change no fit.
void require_no_passage(Session& session, RunId run, std::int64_t row) {
  Query query(session.db,
              "SELECT 1 FROM point JOIN passage USING (point_id) WHERE run_id = ? AND "
              "trajectory_row = ?");
  if (query.bind(run.value, row).row())
    throw_failure(ErrorCode::invalid_argument, reasons::kNoSuchRow,
                  "row " + std::to_string(row + 1) + " of run " + std::to_string(run.value) +
                      " is a passage, where the run came by beside its plan: a passage is in no "
                      "fit. Name rows as 'driftwise run points " +
                      std::to_string(run.value) + "' shows them");
}

std::optional<std::int64_t> number(const std::optional<RunId>& id) {
  return id ? std::optional(id->value) : std::nullopt;
}
std::optional<std::int64_t> number(const std::optional<ModelId>& id) {
  return id ? std::optional(id->value) : std::nullopt;
}

void require_subject(Session& session, const NoteSubject& on) {
  if (on.run.has_value() == on.model.has_value() || (on.row && !on.run))
    throw_failure(ErrorCode::invalid_argument, reasons::kBadSubject,
                  "a note is on a run, on a row of a run, or on a model: name one of them");
  if (on.run) require_run(session, *on.run);
  if (on.row) require_point(session, *on.run, *on.row);
  if (on.model) require_model(session, *on.model);
}

}  // namespace

// The last word on each row. The view excluded_point says the same to a person, and looks through
// all exclusions of the run again for every row of it.
std::map<std::int64_t, ExcludedRow> excluded_rows(Session& session, RunId run) {
  Query query(session.db,
              "SELECT r.trajectory_row, e.excluded, EXISTS (SELECT 1 FROM suspect_mark m WHERE "
              "m.exclusion_id = e.exclusion_id) FROM exclusion e INDEXED BY exclusion_run CROSS "
              "JOIN exclusion_row r USING (exclusion_id) WHERE e.run_id = ? ORDER BY "
              "e.exclusion_id");
  query.bind(run.value);
  std::map<std::int64_t, ExcludedRow> rows;
  while (query.row()) {
    if (query.integer(1) != 0)
      rows[query.integer(0)] = {.suspect = query.integer(2) != 0};
    else
      rows.erase(query.integer(0));
  }
  return rows;
}

ExclusionRecord store_exclusion(Session& session, const ExclusionRecord& wanted) {
  require_run(session, wanted.run);
  for (const std::int64_t row : wanted.rows) require_point(session, wanted.run, row);
  const auto out_now = excluded_rows(session, wanted.run);
  ExclusionRecord stored = wanted;
  std::erase_if(stored.rows,
                [&](std::int64_t row) { return out_now.contains(row) == wanted.excluded; });
  stored.id = 0;
  return stored.rows.empty() ? stored : insert_exclusion(session, stored);
}

ExclusionRecord insert_exclusion(Session& session, const ExclusionRecord& exclusion) {
  ExclusionRecord stored = exclusion;
  Query(session.db,
        "INSERT INTO exclusion (run_id, excluded, reason, who, peer, at_ns, at_monotonic_ns) "
        "VALUES (?, ?, ?, ?, ?, ?, ?)")
      .bind(stored.run, stored.excluded ? 1 : 0, stored.reason, stored.who, stored.from,
            stored.at.utc.utc_ns, stored.at.monotonic_ns)
      .run();
  stored.id = session.db.last_row_id();
  if (stored.suspect)
    Query(session.db, "INSERT INTO suspect_mark (exclusion_id) VALUES (?)").bind(stored.id).run();
  Query row_of(session.db,
               "INSERT INTO exclusion_row (exclusion_id, trajectory_row) VALUES (?, ?)");
  for (const std::int64_t row : stored.rows) row_of.bind(stored.id, row).run();
  return stored;
}

Result<ExclusionRecord> SqliteRemarkStore::exclude(const ExclusionRecord& exclusion) {
  return session_.write([&] {
    require_run(session_, exclusion.run);
    for (const std::int64_t row : exclusion.rows) require_no_passage(session_, exclusion.run, row);
    return store_exclusion(session_, exclusion);
  });
}

Result<std::vector<ExclusionRecord>> SqliteRemarkStore::exclusions(RunId run) {
  return session_.read([&] {
    require_run(session_, run);
    Query query(session_.db,
                "SELECT exclusion_id, excluded, reason, who, peer, at_ns, at_monotonic_ns, "
                "EXISTS (SELECT 1 FROM suspect_mark m WHERE m.exclusion_id = e.exclusion_id) "
                "FROM exclusion e WHERE run_id = ? ORDER BY exclusion_id");
    Query rows(session_.db,
               "SELECT trajectory_row FROM exclusion_row WHERE exclusion_id = ? ORDER BY "
               "trajectory_row");
    query.bind(run.value);
    std::vector<ExclusionRecord> records;
    while (query.row()) {
      ExclusionRecord record{query.integer(0),      run,
                             query.integer(1) != 0, {},
                             query.text(2),         {{query.integer(5)}, query.integer(6)},
                             query.text(3),         query.text(4),
                             query.integer(7) != 0};
      rows.bind(record.id);
      while (rows.row()) record.rows.push_back(rows.integer(0));
      rows.restart();
      records.push_back(std::move(record));
    }
    return records;
  });
}

Result<NoteRecord> SqliteRemarkStore::add_note(const NoteRecord& note) {
  return session_.write([&] {
    require_subject(session_, note.on);
    Query(session_.db,
          "INSERT INTO note (run_id, trajectory_row, model_id, text, who, peer, at_ns, "
          "at_monotonic_ns) VALUES (?, ?, ?, ?, ?, ?, ?, ?)")
        .bind(number(note.on.run), note.on.row, number(note.on.model), note.text, note.who,
              note.from, note.at.utc.utc_ns, note.at.monotonic_ns)
        .run();
    NoteRecord stored = note;
    stored.id = session_.db.last_row_id();
    return stored;
  });
}

Result<std::vector<NoteRecord>> SqliteRemarkStore::notes(const NoteSubject& subject) {
  return session_.read([&] {
    require_subject(session_, subject);
    Query query(session_.db,
                "SELECT note_id, run_id, trajectory_row, model_id, text, who, peer, at_ns, "
                "at_monotonic_ns FROM note WHERE run_id IS ?1 AND model_id IS ?3 AND "
                "(?2 IS NULL OR trajectory_row = ?2) ORDER BY note_id");
    query.bind(number(subject.run), subject.row, number(subject.model));
    std::vector<NoteRecord> notes;
    while (query.row()) {
      NoteRecord note{query.integer(0), {},
                      query.text(4),    {{query.integer(7)}, query.integer(8)},
                      query.text(5),    query.text(6)};
      if (const auto run = query.optional_integer(1)) note.on.run = RunId{*run};
      note.on.row = query.optional_integer(2);
      if (const auto model = query.optional_integer(3)) note.on.model = ModelId{*model};
      notes.push_back(std::move(note));
    }
    return notes;
  });
}

namespace {

TimeNoteRecord time_note_of(Query& query) {
  return {query.integer(0), {query.integer(1)}, query.text(2),
          query.text(3),    query.text(4),      {{query.integer(5)}, query.integer(6)},
          query.text(7),    query.text(8)};
}

}  // namespace

Result<TimeNoteRecord> SqliteRemarkStore::add_time_note(const TimeNoteRecord& note) {
  return session_.write([&] {
    if (!note.request.empty()) {
      Query same(session_.db,
                 "SELECT time_note_id, about_ns, text, channel, request, at_ns, at_monotonic_ns, "
                 "who, peer FROM time_note WHERE request = ? AND request <> ''");
      same.bind(note.request);
      if (same.row()) return time_note_of(same);
    }
    Query(session_.db,
          "INSERT INTO time_note (about_ns, text, channel, request, who, peer, at_ns, "
          "at_monotonic_ns) VALUES (?, ?, ?, ?, ?, ?, ?, ?)")
        .bind(note.about.utc_ns, note.text, note.channel, note.request, note.who, note.from,
              note.at.utc.utc_ns, note.at.monotonic_ns)
        .run();
    TimeNoteRecord stored = note;
    stored.id = session_.db.last_row_id();
    return stored;
  });
}

Result<std::vector<TimeNoteRecord>> SqliteRemarkStore::time_notes(CellTime from, CellTime to,
                                                                  int limit) {
  return session_.read([&] {
    Query query(session_.db,
                "SELECT time_note_id, about_ns, text, channel, request, at_ns, at_monotonic_ns, "
                "who, peer FROM time_note WHERE about_ns >= ? AND about_ns < ? ORDER BY about_ns "
                "DESC, time_note_id DESC LIMIT ?");
    query.bind(from.utc_ns, to.utc_ns, limit);
    std::vector<TimeNoteRecord> notes;
    while (query.row()) notes.push_back(time_note_of(query));
    return notes;
  });
}

}  // namespace driftwise::storage
