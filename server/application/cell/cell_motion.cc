// Who may move, and moving by hand.

#include <fmt/format.h>

#include <algorithm>

#include "server/application/cell/cell_application.h"
#include "server/application/motion/datum_opening.h"
#include "server/application/motion/motion.h"
#include "server/application/motion/start_checks.h"
#include "server/application/plumbing/task_group.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::application {

Result<Lease> CellApplication::take_lease(const Caller& caller, Nanoseconds duration,
                                          const std::string& token) {
  auto lease = leases_.take(caller, duration, token, clock_->now().utc);
  if (lease && token.empty())
    events_.record(caller, "lease.taken",
                   fmt::format("{} may move until {}", caller.name, to_iso8601(utc(lease->until))));
  return lease;
}

Result<void> CellApplication::give_up_lease(const Caller& caller, const std::string& token) {
  auto done = leases_.give_up(token, clock_->now().utc);
  if (done)
    events_.record(caller, "lease.given_up", fmt::format("{} gave the lease up", caller.name));
  return done;
}

Result<void> CellApplication::may_move(const std::string& lease_token) const {
  if (auto ok = stops_.check(); !ok) return ok;
  if (auto ok = leases_.check(lease_token, clock_->now().utc); !ok) return ok;
  if (const auto* run = engine_.record())
    return fail(ErrorCode::failed_precondition, reasons::kRunUnderWay,
                fmt::format("run {} '{}' is {}: abort it, or wait until it is over", run->id.value,
                            run->name, to_string(run->state)));
  if (by_hand_)
    return fail(ErrorCode::failed_precondition, reasons::kMoving,
                "a movement by hand is under way: wait for its end, or stop it");
  return {};
}

Result<void> CellApplication::may_move_by_hand(const Caller& caller, const std::string& lease_token,
                                               const HoldAnswer& answer) const {
  if (!engine_.stands() || by_hand_) return may_move(lease_token);
  if (auto ok = stops_.check(); !ok) return ok;
  if (auto ok = leases_.check(lease_token, clock_->now().utc); !ok) return ok;
  return check_answer(*engine_.record(), engine_.record()->hold, caller.name, answer,
                      clock_->now().utc);
}

// A movement without a run: stop_all and shut_down reach it through by_hand_.
class CellApplication::ByHand {
 public:
  explicit ByHand(CellApplication& cell) : cell_(cell), task_(cell.tasks_.join()) {
    cell_.by_hand_.emplace(cell_.executor_);
  }
  ~ByHand() {
    cell_.by_hand_.reset();
    cell_.by_hand_waits_.clear();
  }
  ByHand(const ByHand&) = delete;
  // what: "homing", for who asks what it waits for.
  RunScope scope(const std::string& what) {
    const auto wait = [this, what](const std::string& why) {
      cell_.by_hand_waits_ = why.empty() ? why : fmt::format("{} waits: {}", what, why);
      if (!why.empty()) cell_.events_.record_own("axes.waiting", cell_.by_hand_waits_);
    };
    return {cell_.workbench_,
            *cell_.by_hand_,
            cell_.description_.run,
            std::nullopt,
            [](const std::string&) {},
            [wait](std::string why) { return at_once(wait, std::move(why)); },
            [wait] { return at_once(wait, ""); }};
  }

 private:
  static Awaitable<Result<void>> at_once(std::function<void(const std::string&)> act,
                                         std::string why) {
    act(why);
    co_return Result<void>{};
  }
  CellApplication& cell_;
  TaskGroup::Membership task_;  // a task of the cell, until the movement is over
};

Awaitable<Result<StopAnswer>> CellApplication::stop_all(Caller caller) {
  const auto* run = engine_.record();
  stop_events_.record(caller, run ? std::optional(run->id) : std::nullopt);
  const auto why = fmt::format("stopped by {}", caller.name);
  if (auto* control = engine_.control())
    control->halt({RunHold::Kind::stop, caller.name, clock_->now().utc, why});
  if (by_hand_) by_hand_->abort(why);
  improver_.halt(why);
  auto pressing = stops_.press(std::move(caller), why);
  co_return co_await std::move(pressing);
}

Awaitable<Result<void>> CellApplication::home(Caller caller, std::string lease_token,
                                              HoldAnswer answer) {
  auto lock = std::optional(co_await beginning_.lock());
  if (auto ok = may_move_by_hand(caller, lease_token, answer); !ok) co_return ok;
  engine_.remeasure_zero("homed by hand");
  ByHand hand(*this);
  lock.reset();
  events_.record(caller, "axes.home", fmt::format("{} references the axes", caller.name));
  auto scope = hand.scope("homing");
  recorder_.lend_pose_instruments(true);
  auto opening = new_datum_by_hand(scope, "homed by " + caller.name);
  auto opened = co_await std::move(opening);
  recorder_.lend_pose_instruments(false);
  DRIFTWISE_CO_RETURN_IF_ERROR(opened);
  take_datum(*opened);
  co_return Result<void>{};
}

// Referenced axes count from somewhere else by some nanometres, so the datum before is over, even
// where no new one can be opened.
Awaitable<Result<DatumRecord>> CellApplication::new_datum_by_hand(RunScope& scope,
                                                                  std::string reason) {
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await make_homed(scope, true));
  datum_trouble_ =
      "the axes were homed and no datum has been opened since: targets still count "
      "from the one before; home again, or start a run";
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await bench_.prepare_for_run());
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await check_thermometers(scope));
  if (description_.load) DRIFTWISE_CO_RETURN_IF_ERROR(co_await loading_.look(bench_));
  DatumOpening opening;
  opening.reason = std::move(reason);
  DRIFTWISE_CO_TRY(auto before, co_await reader_.runs().newest_datum());
  opening.before = std::move(before);
  auto opened = open_datum(scope, std::move(opening));
  co_return co_await std::move(opened);
}

// An actuator is asked in its period; without one a person has said it.
std::optional<double> CellApplication::force_now() const {
  const auto channel = description_.force_channel();
  if (!channel || !description_.load) return std::nullopt;
  if (!description_.load_actuator()) return loading_.known_n();
  const auto* latest = recorder_.history().latest(channel->name());
  if (!latest || is_missing(latest->value)) return std::nullopt;
  return latest->value;
}

Awaitable<bool> CellApplication::axes_measured_at(std::vector<double> q_mm) {
  const auto round = co_await bench_.read_pose_instruments();
  if (!round) co_return false;
  std::vector<ChannelValue> raw;
  for (const auto& reading : *round)
    for (const auto& value : reading.values)
      if (!is_missing(value.value) && !reading.is_rejected(value.channel)) raw.push_back(value);
  co_return doubts_.pose_is_at(pose_.pose(raw), q_mm);
}

// The point under way is not accepted: its attempt ends as interrupted with this reason. The run is
// paused until a person resumes it, and then measures its zero again.
void CellApplication::axes_moved_uncommanded(const std::string& what) {
  motion_trouble_ = fmt::format(
      "the axes moved without a command of this daemon ({}): look who else drives them, then open "
      "a new datum (resume the run, home, or start a run)",
      what);
  const auto* run = engine_.record();
  events_.record_own("motion.uncommanded", motion_trouble_,
                     run ? std::optional(run->id) : std::nullopt);
  engine_.remeasure_zero("uncommanded motion");
  if (auto* control = engine_.control())
    control->halt({RunHold::Kind::trouble, "", clock_->now().utc, motion_trouble_});
  if (by_hand_) by_hand_->abort(motion_trouble_);
  // Own motion ends: a run is paused, a move by hand is given up. At idle the axes are left to
  // whoever moves them.
  if (!engine_.busy() && !by_hand_) return;
  tasks_.spawn(halt_axes());
}

Awaitable<void> CellApplication::halt_axes() { static_cast<void>(co_await bench_.stop()); }

void CellApplication::take_datum(const DatumRecord& datum) {
  motion_trouble_.clear();
  datum_trouble_.clear();
  pose_.set_zero(datum.values);
  serving_.anchor(datum);
}

Awaitable<Result<void>> CellApplication::move_to(Caller caller, std::string lease_token,
                                                 std::vector<double> q_mm, HoldAnswer answer) {
  auto lock = std::optional(co_await beginning_.lock());
  if (auto ok = may_move_by_hand(caller, lease_token, answer); !ok) co_return ok;
  if (auto ok = check_soft_limits(description_, q_mm); !ok) co_return ok;
  engine_.remeasure_zero("moved by hand");
  ByHand hand(*this);
  lock.reset();
  events_.record(caller, "axes.move",
                 fmt::format("{} moves to {} mm", caller.name, fmt::join(q_mm, ", ")));
  auto scope = hand.scope("the movement");
  DRIFTWISE_CO_TRY(const auto arrival,
                   co_await go_to(scope, std::move(q_mm), "by hand: " + caller.name));
  if (arrival.trouble != Trouble::none)
    co_return fail(ErrorCode::deadline_exceeded, reasons::kNotSettled, arrival.sentence);
  co_return Result<void>{};
}

Awaitable<Result<void>> CellApplication::set_stabiliser(Caller caller, std::string lease_token,
                                                        std::string device, double degc) {
  constexpr double kColdest_degC = 5, kHottest_degC = 60;  // of a room and its people
  if (auto ok = leases_.check(lease_token, clock_->now().utc); !ok) co_return ok;
  if (!(degc >= kColdest_degC && degc <= kHottest_degC))
    co_return fail(ErrorCode::invalid_argument, reasons::kSetPoint,
                   fmt::format("{} degC was asked for, expected {:g} to {:g}", degc, kColdest_degC,
                               kHottest_degC));
  std::string known;
  for (const auto i : bench_.with_role(DeviceRole::stabiliser)) {
    const std::string& id = bench_.description(i).id;
    known += (known.empty() ? "" : ", ") + id;
    if (id != device) continue;
    auto set = co_await bench_.set_point(i, degc);
    if (set)
      events_.record(caller, "stabiliser.set",
                     fmt::format("{} set {} to {:g} degC", caller.name, device, degc));
    co_return set;
  }
  auto sentence = fmt::format("the cell has no stabiliser '{}', {}", device,
                              known.empty() ? "nor any other" : "it has " + known);
  co_return fail(ErrorCode::not_found, reasons::kNoStabiliser, std::move(sentence));
}

}  // namespace driftwise::application
