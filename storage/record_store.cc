#include "storage/record_store.h"

#include <set>

#include "storage/diagnosis/job_changes.h"
#include "storage/rows/point_rows.h"
#include "storage/rows/run_rows.h"
#include "storage/watch/alarm_store.h"
#include "storage/watch/event_store.h"

namespace driftwise::storage {
namespace {

std::int64_t greatest(Session& session, const char* sql) {
  Query query(session.db, sql);
  query.row();
  return query.integer(0);
}

// The cursor after a list that may have been cut off at limit.
template <class List, class IdOf>
std::int64_t reached(const List& list, std::int64_t after, std::int64_t until, int limit,
                     IdOf id_of) {
  if (static_cast<int>(list.size()) < limit) return std::max(after, until);
  return id_of(list.back());
}

void read_alarms(Session& session, const RecordCursor& after, const RecordCursor& until, int limit,
                 RecordPage& page) {
  Query query(session.db,
              DRIFTWISE_SELECT_ALARM " WHERE change > ? AND change <= ? ORDER BY change LIMIT ?");
  query.bind(after.alarm, until.alarm, limit);
  while (query.row()) page.alarms.push_back(alarm_from(query));
  page.to.alarm = reached(page.alarms, after.alarm, until.alarm, limit,
                          [](const AlarmRecord& alarm) { return alarm.change; });
}

void read_new_models(Session& session, const RecordCursor& after, const RecordCursor& until,
                     int limit, RecordPage& page) {
  Query models(session.db,
               "SELECT model_id FROM model WHERE model_id > ? AND model_id <= ? ORDER BY model_id "
               "LIMIT ?");
  models.bind(after.model, until.model, limit);
  while (models.row()) page.models.push_back({models.integer(0)});
  page.to.model = reached(page.models, after.model, until.model, limit,
                          [](const ModelId& model) { return model.value; });
  Query promotions(session.db,
                   "SELECT model_id, at_ns, by_whom, action, promotion_id FROM promotion WHERE "
                   "promotion_id > ? AND promotion_id <= ? ORDER BY promotion_id LIMIT ?");
  promotions.bind(after.promotion, until.promotion, limit);
  std::int64_t last = after.promotion;
  while (promotions.row()) {
    PromotionRecord promotion{{}, {promotions.integer(1)}, promotions.text(2), promotions.text(3)};
    if (const auto model = promotions.optional_integer(0)) promotion.model = ModelId{*model};
    page.promotions.push_back(std::move(promotion));
    last = promotions.integer(4);
  }
  page.to.promotion = reached(page.promotions, after.promotion, until.promotion, limit,
                              [last](const PromotionRecord&) { return last; });
}

void read_runs_of(Session& session, RecordPage& page) {
  std::set<RunId> runs;
  for (const auto& event : page.events)
    if (event.run) runs.insert(*event.run);
  for (const auto& attempt : page.attempts) runs.insert(attempt.run);
  for (const RunId run : runs) page.runs.push_back(read_run(session, run));
}

}  // namespace

Result<std::string> SqliteRecordStore::database_id() {
  return session_.read([&] {
    Query query(session_.db, "SELECT id FROM database_identity");
    return query.row() ? query.text(0) : std::string();
  });
}

Result<RecordCursor> SqliteRecordStore::newest() {
  return session_.read([&] {
    return RecordCursor{
        .event = greatest(session_, "SELECT coalesce(max(event_id), 0) FROM event"),
        .attempt = greatest(session_, "SELECT coalesce(max(attempt_id), 0) FROM attempt"),
        .point = greatest(session_, "SELECT coalesce(max(point_id), 0) FROM point"),
        .alarm = greatest(session_, "SELECT coalesce(max(change), 0) FROM alarm"),
        .model = greatest(session_, "SELECT coalesce(max(model_id), 0) FROM model"),
        .promotion = greatest(session_, "SELECT coalesce(max(promotion_id), 0) FROM promotion"),
        .job = newest_job_change(session_)};
  });
}

Result<RecordPage> SqliteRecordStore::records(const RecordCursor& after, const RecordCursor& until,
                                              int limit) {
  return session_.read([&] {
    RecordPage page;
    page.events = read_events(session_, after.event, until.event, limit);
    page.to.event = reached(page.events, after.event, until.event, limit,
                            [](const EventRecord& event) { return event.id.value; });
    std::int64_t last = after.attempt;
    page.attempts = read_attempts_after(session_, after.attempt, until.attempt, limit, last);
    page.to.attempt = reached(page.attempts, after.attempt, until.attempt, limit,
                              [last](const RunAttempt&) { return last; });
    page.points = read_points_after(session_, after.point, until.point, limit);
    page.to.point = reached(page.points, after.point, until.point, limit,
                            [](const PointRecord& point) { return point.id.value; });
    read_alarms(session_, after, until, limit, page);
    read_new_models(session_, after, until, limit, page);
    read_job_changes(session_, after, until, limit, page);
    read_runs_of(session_, page);
    return page;
  });
}

}  // namespace driftwise::storage
