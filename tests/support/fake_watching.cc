// FakeCell as those who watch see it: points and events are the record, numbered by their ids.

#include <algorithm>

#include "tests/support/fake_cell.h"

namespace driftwise::tests {
namespace {

// Those of a list whose number lies above one and up to another, at most limit.
template <class T, class NumberOf>
std::int64_t take_between(const std::vector<T>& all, std::int64_t after, std::int64_t until,
                          int limit, NumberOf number_of, std::vector<T>& out) {
  for (const T& one : all) {
    if (number_of(one) <= after || number_of(one) > until) continue;
    if (static_cast<int>(out.size()) == limit) return number_of(out.back());
    out.push_back(one);
  }
  return std::max(after, until);
}

}  // namespace

Awaitable<Result<app::RecordHead>> FakeCell::record_head() {
  app::RecordHead head{the_database, {}};
  if (!the_events.empty()) head.newest.event = the_events.back().id.value;
  if (!the_points.empty()) head.newest.point = the_points.back().id.value;
  if (!the_alarms.empty()) head.newest.alarm = the_alarms.back().change;
  head.newest.job = std::ssize(the_diagnosis_changes) + std::ssize(the_improvement_changes);
  co_return head;
}

Awaitable<Result<RecordPage>> FakeCell::records(RecordCursor after, RecordCursor until, int limit) {
  ++pages_read;
  RecordPage page;
  page.to = until;
  page.to.event = take_between(
      the_events, after.event, until.event, limit,
      [](const EventRecord& event) { return event.id.value; }, page.events);
  page.to.point = take_between(
      the_points, after.point, until.point, limit,
      [](const PointRecord& point) { return point.id.value; }, page.points);
  page.to.alarm = take_between(
      the_alarms, after.alarm, until.alarm, limit,
      [](const AlarmRecord& alarm) { return alarm.change; }, page.alarms);
  for (std::int64_t change = after.job; change < until.job; ++change) {
    const auto at = static_cast<std::size_t>(change), diagnoses = the_diagnosis_changes.size();
    if (at < diagnoses)
      page.diagnoses.push_back(the_diagnosis_changes[at]);
    else
      page.improvements.push_back(the_improvement_changes[at - diagnoses]);
  }
  co_return page;
}

std::shared_ptr<void> FakeCell::watch_records(std::function<void()> on_news) {
  return counted(event_watch_.add([on_news](const EventRecord&) { on_news(); }));
}

Awaitable<Result<std::vector<AlarmRecord>>> FakeCell::alarms(bool with_history, int) {
  std::vector<AlarmRecord> out;
  for (const auto& alarm : the_alarms)
    if (with_history || alarm.cleared.utc_ns == 0 || alarm.acknowledged.utc_ns == 0)
      out.push_back(alarm);
  co_return out;
}

Awaitable<Result<AlarmRecord>> FakeCell::acknowledge_alarm(app::Caller caller, AlarmId id) {
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  for (auto& alarm : the_alarms)
    if (alarm.id == id) {
      alarm.acknowledged = the_time;
      alarm.acknowledged_by = caller.name;
      co_return alarm;
    }
  co_return fail(ErrorCode::not_found, "NO_SUCH_ALARM", "there is no such alarm");
}

Awaitable<Result<app::PastTargets>> FakeCell::past_targets(app::PastTargetsQuery query) {
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  last_past = query;
  co_return the_past;
}

Awaitable<Result<SeriesAnswer>> FakeCell::series(SeriesQuery query) {
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  last_series = std::move(query);
  co_return the_series;
}

Awaitable<Result<KeptTrajectory>> FakeCell::keep_trajectory(app::Caller caller, std::string name,
                                                            std::string text) {
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  for (const auto& kept : the_trajectories)
    if (kept.text == text) co_return kept;
  KeptTrajectory kept;
  kept.id = {static_cast<std::int64_t>(the_trajectories.size()) + 1};
  kept.name = std::move(name);
  kept.text = std::move(text);
  kept.created = the_time;
  kept.created_by = caller.name;
  the_trajectories.push_back(kept);
  co_return kept;
}

Awaitable<Result<KeptTrajectory>> FakeCell::trajectory(TrajectoryId id) {
  for (const auto& kept : the_trajectories)
    if (kept.id == id) co_return kept;
  co_return fail(ErrorCode::not_found, "NO_SUCH_TRAJECTORY", "there is no such trajectory");
}

Awaitable<Result<std::vector<KeptTrajectory>>> FakeCell::trajectories() {
  std::vector<KeptTrajectory> out(the_trajectories.rbegin(), the_trajectories.rend());
  for (auto& kept : out) kept.text.clear();
  co_return out;
}

}  // namespace driftwise::tests
