#include "server/application/holds/hold_desk.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::application {

HoldDesk::HoldDesk(asio::any_io_executor executor, const CellDescription& description, Clock& clock,
                   const Recorder& recorder, EventLog& events, TaskGroup& tasks, World world)
    : executor_(executor),
      description_(description),
      clock_(clock),
      recorder_(recorder),
      events_(events),
      tasks_(tasks),
      world_(std::move(world)),
      wake_(executor) {
  for (const auto& rule : description.holds) rules_.push_back(Rule{.watch = HoldWatch(rule)});
}

void HoldDesk::start() {
  if (rules_.empty()) return;
  tasks_.spawn(look_for_ever());
}

void HoldDesk::shut_down() {
  ending_ = true;
  wake_.raise();
}

Awaitable<void> HoldDesk::look_for_ever() {
  while (!ending_) {
    look(HoldWatch::Look::usual);
    if (apply(world_.control())) world_.stop_axes();
    const double pause_s = std::max(kLook_s, kLeastWall_s * clock_.speed());
    co_await sleep_unless(clock_, clock_.now().utc + nanoseconds_from_s(pause_s), wake_);
  }
}

void HoldDesk::look_before_motion(RunControl& control) {
  look(HoldWatch::Look::before_motion);
  static_cast<void>(apply(&control));  // nothing moves yet
}

void HoldDesk::look(HoldWatch::Look look) {
  const auto now = clock_.now().utc;
  for (auto& rule : rules_) {
    if (rule.watch.rule().only_while_measuring && !world_.measures())
      rule.watch.clear();
    else
      rule.watch.look(value_of(rule.watch.rule()), now, look);
    tell(rule);
    follow_mark(rule);
  }
}

// A hold may begin and end while one point is measured, and nobody asks meanwhile.
void HoldDesk::follow_mark(Rule& rule) {
  const auto& watch = rule.watch;
  const bool marks = watch.phase() == HoldWatch::Phase::holding && watch.rule().marks;
  if (marks && counts(rule)) {
    if (!rule.marking)
      rule.marking =
          HoldMark{std::max(watch.since(), rule.marks_from), std::nullopt, watch.sentence()};
    return;
  }
  auto ended = std::exchange(rule.marking, std::nullopt);
  if (!ended || world_.control() == nullptr) return;  // without a run there is no point to mark
  ended->until = clock_.now().utc;
  ended_marks_.push_back(*std::move(ended));
}

void HoldDesk::tell(Rule& rule) {
  const bool holds = rule.watch.phase() == HoldWatch::Phase::holding;
  if (holds == rule.told || !rule.watch.seen()) return;
  rule.told = holds;
  const auto& name = rule.watch.rule().name;
  if (holds)
    events_.record_own("hold.begun", fmt::format("hold {}: {}", name, rule.watch.sentence()));
  else
    events_.record_own("hold.ended", fmt::format("hold {}: within its limits again", name));
}

bool HoldDesk::counts(const Rule& rule) const { return rule.aside_until <= clock_.now().utc; }

void HoldDesk::end_where_it_must() {
  for (const auto& rule : rules_) {
    const auto& what = rule.watch.rule();
    if (what.action != HoldAction::end_daemon || !rule.watch.is_measured_beyond(clock_.now().utc) ||
        !counts(rule) || std::exchange(asked_to_end_, true))
      continue;
    events_.record_own("hold.ends_daemon",
                       fmt::format("hold {}: {}; the daemon ends in good order, and the run goes "
                                   "on with its next start",
                                   what.name, rule.watch.sentence()));
    world_.end_daemon();
  }
}

// Several that hold at once are one condition: the first of the file speaks, the strongest action
// is done.
bool HoldDesk::apply(RunControl* control) {
  end_where_it_must();
  if (control == nullptr) return false;
  std::optional<CellCondition> condition;
  for (const auto& rule : rules_) {
    if (rule.watch.phase() != HoldWatch::Phase::holding || !counts(rule)) continue;
    const auto& what = rule.watch.rule();
    if (!condition) {
      condition = CellCondition{
          {RunHold::Kind::condition, "", rule.watch.since(),
           what.advice.empty() ? rule.watch.sentence()
                               : fmt::format("{}: {}", rule.watch.sentence(), what.advice)},
          what.action};
    } else {
      condition->action = std::max(condition->action, what.action);
      condition->hold.reason += "; " + rule.watch.sentence();
    }
  }
  return control->set_condition(std::move(condition));
}

std::optional<double> HoldDesk::fresh(const std::string& channel,
                                      const std::optional<double>& stale_s) const {
  const auto* latest = recorder_.history().latest(channel);
  if (latest == nullptr || latest->at.utc_ns == 0 || is_missing(latest->value)) return std::nullopt;
  const auto* device = description_.find_device(latest->device);
  const bool is_read_always = device != nullptr && device->period_s > 0;
  const auto limit_s = stale_s          ? stale_s
                       : is_read_always ? std::optional(device->max_age_s)
                                        : std::nullopt;
  if (limit_s && seconds_from(clock_.now().utc - latest->at) > *limit_s) return std::nullopt;
  return latest->value;
}

std::optional<double> HoldDesk::value_of(const HoldRule& rule) const {
  const auto one = rule.channel == HoldRule::kDiskFreeGb ? world_.disk_free_gb()
                                                         : fresh(rule.channel, rule.stale_s);
  if (rule.minus.empty() || !one) return one;
  const auto other = fresh(rule.minus, rule.stale_s);
  return other ? std::optional(*one - *other) : std::nullopt;
}

std::vector<HoldMark> HoldDesk::take_marks() {
  auto marks = std::exchange(ended_marks_, {});
  for (const auto& rule : rules_)
    if (rule.marking) marks.push_back(*rule.marking);
  return marks;
}

bool HoldDesk::settles() const {
  bool settles = false;
  for (const auto& rule : rules_) {
    if (rule.watch.phase() != HoldWatch::Phase::holding || !counts(rule)) continue;
    if (!rule.watch.settles()) return false;
    settles = true;
  }
  return settles;
}

HoldStatus HoldDesk::status_of(const Rule& rule) const {
  const bool aside = !counts(rule);
  return {rule.watch.rule(),
          rule.watch.phase(),
          rule.watch.since(),
          rule.watch.sentence(),
          rule.watch.outlook(clock_.now().utc),
          aside ? rule.aside_until : CellTime{},
          aside ? rule.aside_by : std::string(),
          aside ? rule.aside_reason : std::string()};
}

std::vector<HoldStatus> HoldDesk::list() const {
  std::vector<HoldStatus> list;
  for (const auto& rule : rules_) list.push_back(status_of(rule));
  return list;
}

Awaitable<Result<HoldStatus>> HoldDesk::set_aside(Caller caller, std::string name, double for_s,
                                                  std::string reason) {
  const auto rule =
      std::ranges::find_if(rules_, [&](const Rule& one) { return one.watch.rule().name == name; });
  if (rule == rules_.end()) {
    std::string known;
    for (const auto& one : rules_) known += (known.empty() ? "" : ", ") + one.watch.rule().name;
    co_return fail(ErrorCode::not_found, reasons::kNoSuchHold,
                   fmt::format("no hold '{}' in this cell, there {}", name,
                               known.empty() ? std::string("is none") : "are: " + known));
  }
  if (!(for_s >= 0) || for_s > kMost_s)
    co_return fail(ErrorCode::invalid_argument, reasons::kBadDuration,
                   fmt::format("hold {}: found {:g} s, expected 0 (it counts again) to {:g} s",
                               name, for_s, kMost_s));
  if (for_s > 0 && reason.find_first_not_of(" \t\r\n") == std::string::npos)
    co_return fail(ErrorCode::invalid_argument, reasons::kReasonMissing,
                   fmt::format("hold {}: a limit is set aside with a reason in writing, which is "
                               "recorded",
                               name));
  const ActChange change{.subject = fmt::format("hold {}", name), .before = {}, .after = {}};
  if (for_s > 0) {
    auto recording = events_.record_first(
        caller, "hold.set_aside",
        fmt::format("{} sets hold {} aside for {:g} s: {}", caller.name, name, for_s, reason), {},
        change);
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(recording));
  } else {  // more protection waits for no disk
    events_.record(caller, "hold.in_force",
                   fmt::format("{} puts hold {} in force again", caller.name, name), {}, change);
  }
  const auto now = clock_.now().utc;
  const auto was_aside_until = rule->aside_until;
  rule->aside_until = for_s > 0 ? now + nanoseconds_from_s(for_s) : CellTime{};
  rule->marks_from = for_s > 0 ? rule->aside_until : std::min(now, was_aside_until);
  rule->aside_by = caller.name;
  rule->aside_reason = reason;
  follow_mark(*rule);
  if (apply(world_.control())) world_.stop_axes();
  co_return status_of(*rule);
}

}  // namespace driftwise::application
