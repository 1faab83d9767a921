#include "storage/rows/point_rows.h"

#include <charconv>
#include <limits>

#include "server/core/reasons.h"
#include "storage/rows/run_rows.h"

namespace driftwise::storage {
namespace {

std::vector<ChannelValue> values_of(Session& session, Query& query, std::int64_t id) {
  query.bind(id);
  std::vector<ChannelValue> values;
  while (query.row())
    values.push_back({session.names.channel_name(query.integer(0)), query.real(1)});
  query.restart();
  return values;
}

Verdict verdict_from(Session& session, const std::string& text) {
  for (int i = 0; i <= static_cast<int>(Verdict::interrupted); ++i)
    if (to_string(static_cast<Verdict>(i)) == text) return static_cast<Verdict>(i);
  throw_failure(ErrorCode::data_loss, reasons::kDatabaseDamaged,
                "database " + session.db.path() + ": table attempt has the verdict '" + text +
                    "', which no Driftwise wrote: restore what was edited");
}

#define DRIFTWISE_SELECT_ATTEMPT                                                                 \
  "SELECT trajectory_row, number, verdict, reason, started_ns, started_monotonic_ns, ended_ns, " \
  "ended_monotonic_ns, spread_nm"
#define DRIFTWISE_SELECT_POINT                                                         \
  "SELECT point_id, trajectory_row, datum_id, point_set, line, is_zero, measured_ns, " \
  "measured_monotonic_ns, dwell_s, run_id, EXISTS (SELECT 1 FROM passage WHERE "       \
  "passage.point_id = point.point_id)"

AttemptRecord attempt_from(Session& session, const Query& query) {
  AttemptRecord attempt;
  attempt.row = query.integer(0);
  attempt.number = static_cast<int>(query.integer(1));
  attempt.verdict = verdict_from(session, query.text(2));
  attempt.reason = query.text(3);
  attempt.started = {{query.integer(4)}, query.integer(5)};
  attempt.ended = {{query.integer(6)}, query.integer(7)};
  attempt.spread_nm = query.real(8);
  return attempt;
}

// "ma.q1_cmd_mm": of motors that are not q1, q2, ... in order, such as those of several robots.
bool is_named_command(std::string_view channel) {
  return channel.ends_with("_cmd_mm") && commanded_axis(channel) == 0;
}

// Rows of a query until it has none, or most points are there, or one is of another run than only.
// Result: it ended at a point of another run.
bool add_points(Session& session, Query& query, std::optional<RunId> only, std::size_t most,
                std::vector<PointRecord>& points) {
  Query values(session.db,
               "SELECT channel_id, value FROM point_value WHERE point_id = ? ORDER BY channel_id");
  while (points.size() < most && query.row()) {
    PointRecord point;
    point.id = {query.integer(0)};
    point.run = {query.integer(9)};
    if (only && point.run != *only) return true;
    point.row = query.integer(1);
    point.datum = {query.integer(2)};
    point.set = query.text(3) == "validation" ? PointSet::validation : PointSet::calibration;
    point.line = query.integer(4);
    point.zero = query.integer(5) != 0;
    point.passage = query.integer(10) != 0;
    point.measured = {{query.integer(6)}, query.integer(7)};
    point.dwell_s = query.real(8);
    for (ChannelValue& value : values_of(session, values, point.id.value)) {
      if (const std::size_t axis = commanded_axis(value.channel); axis != 0) {
        if (point.commanded_mm.size() < axis) point.commanded_mm.resize(axis, kMissing);
        point.commanded_mm[axis - 1] = value.value;
        continue;
      }
      if (is_named_command(value.channel)) point.commanded_mm.push_back(value.value);
      point.values.push_back(std::move(value));
    }
    points.push_back(std::move(point));
  }
  return false;
}

std::vector<PointRecord> points_from(Session& session, Query& query) {
  std::vector<PointRecord> points;
  add_points(session, query, std::nullopt, std::numeric_limits<std::size_t>::max(), points);
  return points;
}

#define DRIFTWISE_SELECT_DATUM \
  "SELECT datum_id, run_id, opened_ns, opened_monotonic_ns, reason FROM datum"

DatumRecord datum_from(Session& session, const Query& row) {
  Query values(session.db,
               "SELECT channel_id, value FROM datum_value WHERE datum_id = ? ORDER BY channel_id");
  DatumRecord datum;
  datum.id = {row.integer(0)};
  if (!row.is_null(1)) datum.run = RunId{row.integer(1)};
  datum.opened = {{row.integer(2)}, row.integer(3)};
  datum.reason = row.text(4);
  datum.values = values_of(session, values, datum.id.value);
  return datum;
}

}  // namespace

std::string commanded_channel(std::size_t axis) { return "q" + std::to_string(axis) + "_cmd_mm"; }

std::size_t commanded_axis(std::string_view channel) {
  if (!channel.starts_with('q')) return 0;
  std::size_t axis = 0;
  const char* const end = channel.data() + channel.size();
  const auto [stop, code] = std::from_chars(channel.data() + 1, end, axis);
  // 001 is not 1: only a name that commanded_channel gives comes back.
  return code == std::errc{} && axis <= 64 && channel == commanded_channel(axis) ? axis : 0;
}

DatumId insert_datum(Session& session, const DatumRecord& datum,
                     std::optional<std::int64_t> file_datum) {
  Query(session.db,
        "INSERT INTO datum (run_id, opened_ns, opened_monotonic_ns, reason, file_datum) VALUES (?, "
        "?, ?, ?, ?)")
      .bind(datum.run, datum.opened.utc.utc_ns, datum.opened.monotonic_ns, datum.reason, file_datum)
      .run();
  const DatumId id{session.db.last_row_id()};
  Query value_row(
      session.db,
      "INSERT OR IGNORE INTO datum_value (datum_id, channel_id, value) VALUES (?, ?, ?)");
  for (const ChannelValue& value : datum.values)
    value_row.bind(id.value, session.names.channel(value.channel, Names::Use::datum), value.value)
        .run();
  return id;
}

std::int64_t insert_attempt(Session& session, RunId run, const AttemptRecord& attempt) {
  Query(session.db,
        "INSERT INTO attempt (run_id, trajectory_row, number, verdict, reason, started_ns, "
        "started_monotonic_ns, "
        "ended_ns, ended_monotonic_ns, spread_nm) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)")
      .bind(run.value, attempt.row, attempt.number, to_string(attempt.verdict), attempt.reason,
            attempt.started.utc.utc_ns, attempt.started.monotonic_ns, attempt.ended.utc.utc_ns,
            attempt.ended.monotonic_ns, attempt.spread_nm)
      .run();
  return session.db.last_row_id();
}

PointId insert_point(Session& session, RunId run, const PointRecord& point, const FromFile& file) {
  Query(
      session.db,
      "INSERT INTO point (run_id, trajectory_row, datum_id, point_set, line, is_zero, measured_ns, "
      "measured_monotonic_ns, dwell_s, file_time_s, file_run) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, "
      "?, ?)")
      .bind(run.value, point.row, point.datum.value,
            point.set == PointSet::validation ? "validation" : "calibration", point.line,
            point.zero ? 1 : 0, point.measured.utc.utc_ns, point.measured.monotonic_ns,
            point.dwell_s, file.time_s, file.run)
      .run();
  const PointId id{session.db.last_row_id()};
  // IGNORE: a channel named twice keeps its first value.
  Query value_row(
      session.db,
      "INSERT OR IGNORE INTO point_value (point_id, channel_id, value) VALUES (?, ?, ?)");
  const auto add = [&](const std::string& channel, double value) {
    value_row.bind(id.value, session.names.channel(channel, Names::Use::point), value).run();
  };
  bool are_named = false;
  for (const ChannelValue& value : point.values) {
    add(value.channel, value.value);
    are_named = are_named || is_named_command(value.channel);
  }
  for (std::size_t axis = 1; !are_named && axis <= point.commanded_mm.size(); ++axis)
    add(commanded_channel(axis), point.commanded_mm[axis - 1]);
  if (point.passage)
    Query(session.db, "INSERT INTO passage (point_id) VALUES (?)").bind(id.value).run();
  return id;
}

void insert_passages(Session& session, RunId run, const std::vector<PointRecord>& passages) {
  for (PointRecord passage : passages) {
    Query next(session.db,
               "SELECT max(trajectory_rows, coalesce((SELECT max(trajectory_row) + 1 FROM point p "
               "WHERE p.run_id = run.run_id), 0)) FROM run WHERE run_id = ?");
    if (!next.bind(run.value).row()) throw_no_such_run(session, run);
    passage.row = next.integer(0);
    passage.passage = true;
    insert_point(session, run, passage, {});
  }
}

std::vector<DatumRecord> read_datums(Session& session, RunId run) {
  Query query(session.db, DRIFTWISE_SELECT_DATUM " WHERE run_id = ? ORDER BY datum_id");
  query.bind(run.value);
  std::vector<DatumRecord> datums;
  while (query.row()) datums.push_back(datum_from(session, query));
  return datums;
}

std::optional<DatumRecord> read_newest_datum(Session& session) {
  Query query(session.db,
              DRIFTWISE_SELECT_DATUM " WHERE reason <> 'imported' ORDER BY datum_id DESC LIMIT 1");
  if (!query.row()) return std::nullopt;
  return datum_from(session, query);
}

std::vector<AttemptRecord> read_attempts(Session& session, RunId run) {
  Query query(session.db,
              DRIFTWISE_SELECT_ATTEMPT " FROM attempt WHERE run_id = ? ORDER BY attempt_id");
  query.bind(run.value);
  std::vector<AttemptRecord> attempts;
  while (query.row()) attempts.push_back(attempt_from(session, query));
  return attempts;
}

std::vector<RunAttempt> read_attempts_after(Session& session, std::int64_t after,
                                            std::int64_t until, int limit, std::int64_t& last) {
  Query query(session.db, DRIFTWISE_SELECT_ATTEMPT
              ", run_id, attempt_id FROM attempt WHERE attempt_id > ? AND attempt_id <= ? ORDER BY "
              "attempt_id LIMIT ?");
  query.bind(after, until, limit);
  std::vector<RunAttempt> attempts;
  while (query.row()) {
    attempts.push_back({{query.integer(9)}, attempt_from(session, query)});
    last = query.integer(10);
  }
  return attempts;
}

// A page of a run. The index over the rows of a run has them in the order of the plan, so that
// every page by it would sort the whole run. The points themselves are in the order asked for, and
// those of a run stand together except where another run came between: they are walked until a
// point of another run, and only then the index is asked where this one goes on, and ends.
std::vector<PointRecord> read_points(Session& session, RunId run, std::int64_t after_id,
                                     int limit) {
  const std::size_t most =
      limit > 0 ? static_cast<std::size_t>(limit) : std::numeric_limits<std::size_t>::max();
  std::vector<PointRecord> points;
  {
    Query next(session.db, DRIFTWISE_SELECT_POINT
               " FROM point NOT INDEXED WHERE point_id > ? ORDER BY point_id");
    next.bind(after_id);
    if (!add_points(session, next, run, most, points)) return points;
  }
  const std::int64_t reached = points.empty() ? after_id : points.back().id.value;
  Query rest(session.db,
             "SELECT min(point_id), max(point_id) FROM point WHERE run_id = ? AND point_id > ?");
  if (!rest.bind(run.value, reached).row() || rest.is_null(0)) return points;
  Query query(session.db, DRIFTWISE_SELECT_POINT
              " FROM point NOT INDEXED WHERE run_id = ? AND point_id BETWEEN ? AND ? ORDER BY "
              "point_id");
  query.bind(run.value, rest.integer(0), rest.integer(1));
  add_points(session, query, run, most, points);
  return points;
}

std::vector<PointRecord> read_points_after(Session& session, std::int64_t after, std::int64_t until,
                                           int limit) {
  Query query(session.db, DRIFTWISE_SELECT_POINT
              " FROM point WHERE point_id > ? AND point_id <= ? ORDER BY point_id LIMIT ?");
  query.bind(after, until, limit);
  return points_from(session, query);
}

}  // namespace driftwise::storage
