#include "server/application/queue/queue_service.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "server/application/datasets/declared_channels.h"
#include "server/application/ports/run_plan.h"
#include "server/application/runs/runs_service.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::application {
namespace {

constexpr int kMostOpen = 1000;
constexpr std::size_t kMostFollowUps = 20;
constexpr double kLeastRepeat_s = 60;

tl::unexpected<Error> no_such_entry(QueueEntryId id) {
  return fail(ErrorCode::not_found, reasons::kNoSuchQueueEntry,
              fmt::format("there is no entry {} in the queue: 'driftwise queue list' shows those "
                          "there are",
                          id.value));
}

// What an entry waits for and does, for the audit.
std::string terms_of(const QueueEntry& entry) {
  auto text = fmt::format("'{}', priority {}", entry.name, entry.priority);
  if (entry.not_before.ns != 0) text += ", not before " + to_iso8601(entry.not_before);
  if (entry.after) text += fmt::format(", after entry {}", entry.after->value);
  if (!entry.condition.empty()) text += ", when " + entry.condition;
  if (const auto plan = read_run_plan(entry.rules_json); plan && !plan->setup.empty())
    text += ", set-up " + plan->setup;
  text += fmt::format(", on failure {}", to_string(entry.on_failure));
  if (entry.repeat_every_s > 0) text += ", every " + span_text(entry.repeat_every_s);
  for (const auto& follow_up : entry.follow_ups) text += ", then " + follow_up;
  if (!entry.metadata.empty()) text += ", " + metadata_text(entry.metadata);
  return text;
}

}  // namespace

// What an entry says beside its trajectory; the condition becomes as it is stored.
Result<void> QueueService::check_terms(QueueEntry& entry) const {
  DRIFTWISE_TRY(entry.metadata, checked_metadata(std::move(entry.metadata)));
  if (!entry.condition.empty()) {
    DRIFTWISE_TRY(const auto condition,
                  parse_condition(entry.condition, channels_for_conditions(description_)));
    entry.condition = to_string(condition);
  }
  if (entry.repeat_every_s != 0 &&
      !(entry.repeat_every_s >= kLeastRepeat_s && entry.repeat_every_s <= kMostAsked_s))
    return fail(ErrorCode::invalid_argument, reasons::kBadRepeat,
                fmt::format("repeat: found {:g} s, expected 0 (once) or a minute to 366 days",
                            entry.repeat_every_s));
  if (entry.follow_ups.size() > kMostFollowUps)
    return fail(ErrorCode::invalid_argument, reasons::kBadFollowUp,
                fmt::format("follow-ups: found {}, expected at most {}", entry.follow_ups.size(),
                            kMostFollowUps));
  for (const auto& text : entry.follow_ups) {
    DRIFTWISE_TRY(const auto follow_up, parse_follow_up(text));
    if (!follow_up.formula.empty())
      DRIFTWISE_RETURN_IF_ERROR(check_formula_reads(description_, follow_up.formula));
  }
  if (entry.after) return check_dependency(desk_.entries(), entry.id, *entry.after);
  return {};
}

Awaitable<Result<QueueLine>> QueueService::add(Caller caller, QueueDraft draft) {
  if (draft.rules) DRIFTWISE_CO_RETURN_IF_ERROR(check_rules(*draft.rules));
  DRIFTWISE_CO_RETURN_IF_ERROR(check_setup(description_, draft.setup));
  const auto name =
      draft.trajectory_name.empty() ? std::string("trajectory") : draft.trajectory_name;
  auto checking = trajectories_.check(name, draft.trajectory_text);
  DRIFTWISE_CO_TRY(const auto check, co_await std::move(checking));
  const bool compensates = draft.compensate || draft.compensate_with;
  DRIFTWISE_CO_RETURN_IF_ERROR(check_coordinates(name, check.trajectory, compensates));
  if (draft.compensate_with) {
    auto looking = models_.get(*draft.compensate_with);
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(looking));
  }
  const auto lock = co_await desk_.turn();
  int open = 0;
  for (const auto& entry : desk_.entries()) {
    if (!draft.request_id.empty() && entry.request_id == draft.request_id)
      co_return QueueLine{entry, desk_.waits_for(entry.id)};
    open += is_over(entry.state) ? 0 : 1;
  }
  if (open >= kMostOpen)
    co_return fail(ErrorCode::resource_exhausted, reasons::kQueueFull,
                   fmt::format("the queue has {} entries: remove some", open));
  QueueEntry entry;
  entry.id = desk_.next_id();
  entry.place = desk_.last_place() + 1;
  entry.name = draft.name.empty() ? name : draft.name;
  entry.trajectory_name = name;
  entry.trajectory_text = std::move(draft.trajectory_text);
  entry.rows = static_cast<std::int64_t>(check.trajectory.points.size());
  entry.rules_json = write_waiting_plan(draft.rules, draft.setup);
  entry.compensate = compensates;
  entry.compensate_with = draft.compensate_with;
  entry.metadata = std::move(draft.metadata);
  entry.priority = draft.priority;
  entry.not_before = draft.not_before;
  entry.after = draft.after;
  entry.condition = std::move(draft.condition);
  entry.on_failure = draft.on_failure;
  entry.repeat_every_s = draft.repeat_every_s;
  entry.follow_ups = std::move(draft.follow_ups);
  entry.request_id = std::move(draft.request_id);
  entry.created = clock_.now().utc;
  entry.created_by = caller.name;
  entry.created_from = caller.peer;
  DRIFTWISE_CO_RETURN_IF_ERROR(check_terms(entry));
  QueueChange adding;
  adding.put.push_back(entry);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await desk_.change(std::move(adding)));
  events_.record(caller, "queue.added",
                 fmt::format("{} added {}: {} rows", caller.name, entry_text(entry), entry.rows),
                 {}, {fmt::format("queue entry {}", entry.id.value), "", terms_of(entry)});
  desk_.look_now();
  co_return QueueLine{entry, desk_.waits_for(entry.id)};
}

// One that a person may still change. verb: "be moved".
Result<QueueEntry> QueueService::open_entry(QueueEntryId id, const char* verb) const {
  const auto* entry = find_entry(desk_.entries(), id);
  if (!entry) return no_such_entry(id);
  if (entry->state == QueueState::waiting || entry->state == QueueState::set_aside) return *entry;
  const bool runs = entry->state == QueueState::running && entry->run;
  return fail(
      ErrorCode::failed_precondition, reasons::kQueueEntryBegun,
      fmt::format("{} cannot {}: it is {}{}", entry_text(*entry), verb, to_string(entry->state),
                  runs ? fmt::format(", run {}: abort that", entry->run->value) : std::string()));
}

Awaitable<Result<QueueLine>> QueueService::change(Caller caller, QueueEntryId id, QueueEdit edit) {
  const auto lock = co_await desk_.turn();
  DRIFTWISE_CO_TRY(auto entry, open_entry(id, "be changed"));
  const auto before = terms_of(entry);
  if (edit.name && !edit.name->empty()) entry.name = *edit.name;
  if (edit.priority) entry.priority = *edit.priority;
  if (edit.not_before) entry.not_before = *edit.not_before;
  if (edit.after) entry.after = edit.after->value == 0 ? std::nullopt : edit.after;
  if (edit.condition) entry.condition = *edit.condition;
  if (edit.on_failure) entry.on_failure = *edit.on_failure;
  if (edit.repeat_every_s) entry.repeat_every_s = *edit.repeat_every_s;
  DRIFTWISE_CO_TRY(edit.set_metadata, checked_metadata(std::move(edit.set_metadata)));
  entry.metadata =
      changed_metadata(std::move(entry.metadata), edit.set_metadata, edit.remove_metadata);
  DRIFTWISE_CO_RETURN_IF_ERROR(check_terms(entry));
  QueueChange changing;
  changing.put.push_back(entry);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await desk_.change(std::move(changing)));
  events_.record(caller, "queue.changed",
                 fmt::format("{} changed {}", caller.name, entry_text(entry)), {},
                 {fmt::format("queue entry {}", id.value), before, terms_of(entry)});
  desk_.look_now();
  co_return QueueLine{entry, desk_.waits_for(id)};
}

Awaitable<Result<QueueLine>> QueueService::move(Caller caller, QueueEntryId id,
                                                std::optional<QueueEntryId> before) {
  const auto lock = co_await desk_.turn();
  DRIFTWISE_CO_TRY(auto entry, open_entry(id, "be moved"));
  std::vector<QueueEntry> order;
  for (const auto* other : waiting_in_order(desk_.entries()))
    if (other->id != id) order.push_back(*other);
  auto at = order.end();
  if (before && before->value == 0) {
    at = order.begin();
  } else if (before) {
    at = std::ranges::find(order, *before, &QueueEntry::id);
    if (*before == id || at == order.end()) co_return no_such_entry(*before);
  }
  if (at != order.end())
    entry.priority = at->priority;
  else if (!order.empty())
    entry.priority = order.back().priority;
  const auto position = at - order.begin();
  entry.state = QueueState::waiting;
  entry.reason.clear();
  order.insert(at, entry);
  std::int64_t place = 0;
  for (auto& one : order) one.place = ++place;
  auto moved = order[static_cast<std::size_t>(position)];
  QueueChange moving;
  moving.put = std::move(order);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await desk_.change(std::move(moving)));
  events_.record(
      caller, "queue.moved",
      fmt::format("{} moved {} to place {}", caller.name, entry_text(moved), position + 1), {},
      {fmt::format("queue entry {}", id.value), "", fmt::format("place {}", position + 1)});
  desk_.look_now();
  co_return QueueLine{moved, desk_.waits_for(id)};
}

Awaitable<Result<QueueLine>> QueueService::remove(Caller caller, QueueEntryId id,
                                                  std::string reason) {
  const auto lock = co_await desk_.turn();
  DRIFTWISE_CO_TRY(auto entry, open_entry(id, "be removed"));
  const auto before = terms_of(entry);
  entry.state = QueueState::removed;
  entry.reason = fmt::format("removed by {}{}{}", caller.name, reason.empty() ? "" : ": ", reason);
  entry.ended = clock_.now().utc;
  QueueChange removing;
  removing.put.push_back(entry);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await desk_.change(std::move(removing)));
  events_.record(caller, "queue.removed", fmt::format("{}: {}", entry_text(entry), entry.reason),
                 {}, {fmt::format("queue entry {}", id.value), before, ""});
  desk_.look_now();
  co_return QueueLine{entry, ""};
}

Awaitable<Result<QueueHold>> QueueService::hold(Caller caller, std::string reason) {
  const auto lock = co_await desk_.turn();
  QueueChange holding;
  holding.hold = QueueHold{
      true, caller.name,
      fmt::format("{}{}{}{}", kHeldByPerson, caller.name, reason.empty() ? "" : ": ", reason),
      clock_.now().utc};
  const auto before = desk_.hold();
  const auto after = *holding.hold;
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await desk_.change(std::move(holding)));
  events_.record(caller, "queue.held", "the queue is " + after.why, {},
                 {"queue", before.held ? before.why : "", after.why});
  co_return desk_.hold();
}

Awaitable<Result<void>> QueueService::release(Caller caller) {
  const auto lock = co_await desk_.turn();
  const auto before = desk_.hold();
  if (!before.held) co_return Result<void>{};
  // A stop that is not on record yet would hold the record's queue again after the release.
  DRIFTWISE_CO_RETURN_IF_ERROR(desk_.check_stops());
  QueueChange releasing;
  releasing.hold = QueueHold{false, caller.name, "", clock_.now().utc};
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await desk_.change(std::move(releasing)));
  if (desk_.hold().held)
    co_return fail(ErrorCode::aborted, reasons::kStoppedMeanwhile,
                   fmt::format("the queue stays held, {}: release it again", desk_.hold().why));
  events_.record(caller, "queue.released",
                 fmt::format("{} released the queue, which was held: {}", caller.name, before.why),
                 {}, {"queue", before.why, ""});
  desk_.look_now();
  co_return Result<void>{};
}

QueueView QueueService::list() const {
  QueueView view;
  view.hold = desk_.hold();
  const auto& entries = desk_.entries();
  const auto waits = desk_.waits();
  const auto outlooks = desk_.outlooks();
  const auto outlook_of = [&outlooks](QueueEntryId id) -> std::optional<EntryOutlook> {
    const auto found = outlooks.find(id);
    return found == outlooks.end() ? std::nullopt : std::optional(found->second);
  };
  const auto add_all = [&](auto wanted) {
    for (const auto& entry : entries)
      if (wanted(entry.state)) view.lines.push_back({entry, "", outlook_of(entry.id)});
  };
  add_all([](QueueState s) { return s == QueueState::running; });
  add_all([](QueueState s) { return s == QueueState::following; });
  for (const auto* entry : waiting_in_order(entries))
    view.lines.push_back({*entry, waits.at(entry->id), outlook_of(entry->id)});
  add_all([](QueueState s) { return s == QueueState::set_aside; });
  for (auto entry = entries.rbegin(); entry != entries.rend(); ++entry)
    if (is_over(entry->state)) view.lines.push_back({*entry, ""});
  return view;
}

Result<QueueLine> QueueService::get(QueueEntryId id) const {
  const auto* entry = find_entry(desk_.entries(), id);
  if (!entry) return no_such_entry(id);
  auto outlooks = desk_.outlooks(id);
  const auto outlook = outlooks.find(id);
  return QueueLine{
      *entry, desk_.waits_for(id),
      outlook == outlooks.end() ? std::nullopt : std::optional(std::move(outlook->second))};
}

}  // namespace driftwise::application
