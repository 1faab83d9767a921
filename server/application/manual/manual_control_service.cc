#include "server/application/manual/manual_control_service.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "server/application/motion/datum_opening.h"
#include "server/application/motion/motion.h"
#include "server/application/motion/start_checks.h"
#include "server/application/plumbing/task_group.h"
#include "server/application/recording/motion_watch.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::application {
namespace {

// "0.5, 1", or with several robots "ma.q1 0.5, ma.q2 1".
std::string places_of(const CellDescription& cell, const std::vector<double>& q_mm) {
  const auto motors = cell.motor_channels();
  std::string text;
  for (std::size_t i = 0; i < q_mm.size(); ++i) {
    if (is_missing(q_mm[i])) continue;
    if (!text.empty()) text += ", ";
    text += cell.has_several_robots() && i < motors.size()
                ? fmt::format("{} {}", motors[i].symbol, q_mm[i])
                : fmt::format("{}", q_mm[i]);
  }
  return text;
}

// Of several robots those with a coordinate; one robot moves as a whole.
AxesToMove robots_to_move(const CellDescription& cell, const std::vector<double>& q_mm) {
  AxesToMove moved;
  if (!cell.has_several_robots()) return moved;
  const auto axes = cell.motor_channels();
  std::set<std::string_view> named;
  for (std::size_t i = 0; i < std::min(axes.size(), q_mm.size()); ++i)
    if (!is_missing(q_mm[i])) named.insert(robot_of(axes[i].symbol));
  for (const auto& axis : axes) moved.named.push_back(named.contains(robot_of(axis.symbol)));
  return moved;
}

}  // namespace

ManualControlService::ManualControlService(asio::any_io_executor executor, Workbench& bench,
                                           StoreReader& reader, RunEngine& engine,
                                           RightToMove& right, LeaseBook& leases,
                                           StopEvents& stop_events, Serving& serving,
                                           TaskGroup& tasks,
                                           std::function<void(const std::string&)> on_stop)
    : executor_(std::move(executor)),
      workbench_(bench),
      description_(bench.description),
      clock_(bench.clock),
      bench_(bench.devices),
      recorder_(bench.recorder),
      events_(bench.events),
      pose_(bench.pose),
      loading_(bench.loading),
      stops_(bench.stops),
      doubts_(bench.doubts),
      reader_(reader),
      engine_(engine),
      right_(right),
      leases_(leases),
      stop_events_(stop_events),
      serving_(serving),
      tasks_(tasks),
      on_stop_(std::move(on_stop)) {}

void ManualControlService::start() {
  bench_.allow_motion_if([this]() -> Result<void> {
    const auto allowed = stops_.check();
    if (!allowed) return fail(ErrorCode::aborted, allowed.error().reason, allowed.error().message);
    const auto* control = right_.by_hand() ? nullptr : engine_.control();
    return control ? control->check() : Result<void>{};
  });
  bench_.watch_motion(
      MotionWatch::kPerInPosition * description_.run.in_position_nm,
      [this](std::vector<double> q_mm) { return axes_measured_at(std::move(q_mm)); },
      [this](const MotionFinding& found) { motion_found(found); });
}

Result<Lease> ManualControlService::take_lease(const Caller& caller, Nanoseconds duration,
                                               const std::string& token) {
  auto lease = leases_.take(caller, duration, token, clock_.now().utc);
  if (lease && token.empty())
    events_.record(
        caller, "lease.taken",
        fmt::format("{} may move until {}", caller.name, to_iso8601(clock_.utc(lease->until))));
  return lease;
}

Result<void> ManualControlService::give_up_lease(const Caller& caller, const std::string& token) {
  auto done = leases_.give_up(token, clock_.now().utc);
  if (done)
    events_.record(caller, "lease.given_up", fmt::format("{} gave the lease up", caller.name));
  return done;
}

// A movement without a run: stop_all and shut_down reach it through RightToMove::by_hand.
class ManualControlService::ByHand {
 public:
  explicit ByHand(ManualControlService& service)
      : service_(service), control_(service.right_.begin_by_hand()), task_(service.tasks_.join()) {}
  ~ByHand() {
    service_.right_.end_by_hand();
    service_.waits_.clear();
  }
  ByHand(const ByHand&) = delete;
  // what: "homing", for who asks what it waits for.
  RunScope scope(const std::string& what) {
    const auto wait = [this, what](const std::string& why) {
      service_.waits_ = why.empty() ? why : fmt::format("{} waits: {}", what, why);
      if (!why.empty()) service_.events_.record_own("axes.waiting", service_.waits_);
    };
    return {service_.workbench_,
            control_,
            service_.description_.run,
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
  ManualControlService& service_;
  RunControl& control_;
  TaskGroup::Membership task_;  // a task of the cell, until the movement is over
};

Awaitable<Result<StopAnswer>> ManualControlService::stop_all(Caller caller) {
  const auto* run = engine_.record();
  stop_events_.record(caller, run ? std::optional(run->id) : std::nullopt);
  const auto why = stop_events_.hold().reason;
  if (auto* control = engine_.control()) control->halt(stop_events_.hold());
  if (auto* by_hand = right_.by_hand()) by_hand->abort(why);
  // A client that steers from outside sees no stop between two of its movements.
  leases_.end(why);
  on_stop_(why);
  auto pressing = stops_.press(std::move(caller), why, stop_events_.hold().at);
  co_return co_await std::move(pressing);
}

Awaitable<Result<void>> ManualControlService::home(Caller caller, std::string lease_token,
                                                   HoldAnswer answer) {
  auto lock = std::optional(co_await right_.turn());
  if (auto ok = right_.check_by_hand(caller, lease_token, answer); !ok) co_return ok;
  ByHand hand(*this);
  lock.reset();
  auto recording =
      events_.record_first(caller, "axes.home", fmt::format("{} references the axes", caller.name));
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(recording));
  engine_.remeasure_zero("homed by hand");
  auto scope = hand.scope("homing");
  recorder_.lend_pose_instruments(true);
  auto opening = new_datum_by_hand(scope, "homed by " + caller.name);
  auto opened = co_await std::move(opening);
  recorder_.lend_pose_instruments(false);
  if (!opened) {
    events_.record_own("axes.home_failed", fmt::format("homing by {} ended without a datum: {}",
                                                       caller.name, opened.error().message));
    co_await press_where_it_moves_on(caller, opened.error());
    // At the end of the daemon the controller says "stopped", which says nothing of why.
    if (scope.control.shutting_down()) co_return scope.control.check();
  }
  DRIFTWISE_CO_RETURN_IF_ERROR(opened);
  take_datum(*opened);
  co_return Result<void>{};
}

// Referenced axes count from somewhere else by some nanometres, so the datum before is over from
// the moment the reference is sent, even where no new one can be opened.
Awaitable<Result<DatumRecord>> ManualControlService::new_datum_by_hand(RunScope& scope,
                                                                       std::string reason) {
  auto asking = ask_devices_of_datum(scope);
  if (const auto asked = co_await std::move(asking); !asked) {
    auto trouble = asked.error();
    trouble.message += "; nothing has moved: a homing opens a datum, which needs it";
    co_return tl::unexpected(std::move(trouble));
  }
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await clear_to_home(scope, true, SwitchOn::yes));
  const auto no_datum_since = [](const char* what) {
    return fmt::format(
        "{} and no datum has been opened since: targets still count from the one before; home "
        "again, or start a run",
        what);
  };
  const auto trouble_before =
      std::exchange(datum_trouble_, no_datum_since("the homing of the axes was begun"));
  auto homed = co_await send_home(scope);
  if (!homed && homed.error().reason == reasons::kStopPending) datum_trouble_ = trouble_before;
  DRIFTWISE_CO_RETURN_IF_ERROR(homed);
  datum_trouble_ = no_datum_since("the axes were homed");
  auto opening = datum_where_homed(scope, std::move(reason));
  auto opened = co_await std::move(opening);
  if (!opened)
    opened.error().message = "the axes have moved to their reference, and no datum was opened: " +
                             opened.error().message;
  co_return opened;
}

// Axes that are homed for a datum that cannot be opened lose the one before for nothing. A beam or
// spot that is lost is an answer: the homing may bring it back.
Awaitable<Result<void>> ManualControlService::ask_devices_of_datum(RunScope& scope) {
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await bench_.prepare_for_run());
  static constexpr DeviceRole kOfThePose[] = {DeviceRole::angle, DeviceRole::length};
  for (const auto role : kOfThePose)
    for (const auto device : bench_.with_role(role)) {
      const auto reading = co_await bench_.read(device);
      if (!reading && is_device_loss(reading.error())) co_return tl::unexpected(reading.error());
    }
  if (description_.load) DRIFTWISE_CO_RETURN_IF_ERROR(co_await loading_.look(bench_));
  co_return co_await check_thermometers(scope);
}

Awaitable<Result<DatumRecord>> ManualControlService::datum_where_homed(RunScope& scope,
                                                                       std::string reason) {
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await bench_.prepare_for_run());
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await check_thermometers(scope));
  if (description_.load) DRIFTWISE_CO_RETURN_IF_ERROR(co_await loading_.look(bench_));
  DatumOpening opening;
  opening.reason = std::move(reason);
  DRIFTWISE_CO_TRY(opening.before, co_await reader_.points().newest_datum());
  auto opened = open_datum(scope, std::move(opening));
  co_return co_await std::move(opened);
}

Awaitable<bool> ManualControlService::axes_measured_at(std::vector<double> q_mm) {
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
void ManualControlService::motion_found(const MotionFinding& found) {
  std::string kind, trouble;
  switch (found.kind) {
    case MotionFinding::Kind::moved:
      kind = "motion.uncommanded";
      trouble = motion_trouble_ = fmt::format(
          "the axes moved without a command of this daemon ({}): look who else drives them, then "
          "open a new datum (resume the run, home, or start a run)",
          found.sentence);
      engine_.remeasure_zero("uncommanded motion");
      break;
    case MotionFinding::Kind::halted:
      kind = "motion.halted";
      trouble = fmt::format(
          "the controller halted the axes on their way ({}): look at the axes and their limit "
          "switches, then resume the run or move again",
          found.sentence);
      break;
    case MotionFinding::Kind::servo_off:
      kind = "motion.servo_off";
      trouble = fmt::format(
          "the servo was switched off at the controller ({}): look who switched it off and why; "
          "then home or resume the run, which switches it on, or switch it on at the controller",
          found.sentence);
      break;
  }
  const auto* run = engine_.record();
  events_.record_own(kind, trouble, run ? std::optional(run->id) : std::nullopt);
  if (auto* control = engine_.control())
    control->halt({RunHold::Kind::trouble, "", clock_.now().utc, trouble});
  if (auto* by_hand = right_.by_hand()) by_hand->abort(trouble);
  // Own motion ends: a run is paused, a move by hand is given up. At idle the axes are left to
  // whoever moves them.
  if (!engine_.busy() && !right_.by_hand()) return;
  tasks_.spawn(halt_axes());
}

Awaitable<void> ManualControlService::halt_axes() { static_cast<void>(co_await bench_.stop()); }

void ManualControlService::take_datum(const DatumRecord& datum) {
  motion_trouble_.clear();
  datum_trouble_.clear();
  pose_.set_zero(datum.values);
  serving_.anchor(datum);
}

Awaitable<Result<void>> ManualControlService::move_to(Caller caller, std::string lease_token,
                                                      std::vector<double> q_mm, HoldAnswer answer) {
  auto lock = std::optional(co_await right_.turn());
  if (auto ok = right_.check_by_hand(caller, lease_token, answer); !ok) co_return ok;
  const auto moved = robots_to_move(description_, q_mm);
  if (auto ok = check_soft_limits(description_, q_mm, moved); !ok) co_return ok;
  ByHand hand(*this);
  lock.reset();
  auto recording = events_.record_first(
      caller, "axes.move",
      fmt::format("{} moves to {} mm", caller.name, places_of(description_, q_mm)));
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(recording));
  engine_.remeasure_zero("moved by hand");
  auto scope = hand.scope("the movement");
  const auto arrival = co_await go_to(scope, std::move(q_mm), "by hand: " + caller.name, moved);
  if (!arrival) co_await press_where_it_moves_on(caller, arrival.error());
  if (!arrival && scope.control.shutting_down()) co_return scope.control.check();
  DRIFTWISE_CO_RETURN_IF_ERROR(arrival);
  if (arrival->trouble != Trouble::none)
    co_return fail(ErrorCode::deadline_exceeded, reasons::kNotSettled, arrival->sentence);
  co_return Result<void>{};
}

// A controller that moves on after the halt, or cannot be asked whether it does, is told for as
// long as it takes.
Awaitable<void> ManualControlService::press_where_it_moves_on(Caller caller, Error ended) {
  if (ended.reason != reasons::kNotSettled) co_return;
  auto pressing = stops_.press(std::move(caller), std::move(ended.message));
  static_cast<void>(co_await std::move(pressing));
}

Awaitable<Result<void>> ManualControlService::set_stabiliser(Caller caller, std::string lease_token,
                                                             std::string device, double degc) {
  constexpr double kColdest_degC = 5, kHottest_degC = 60;  // of a room and its people
  if (auto ok = leases_.check(lease_token, clock_.now().utc); !ok) co_return ok;
  if (!(degc >= kColdest_degC && degc <= kHottest_degC))
    co_return fail(ErrorCode::invalid_argument, reasons::kSetPoint,
                   fmt::format("{} degC was asked for, expected {:g} to {:g}", degc, kColdest_degC,
                               kHottest_degC));
  DRIFTWISE_CO_TRY(const auto i, stabiliser_named(device));
  auto recording = events_.record_first(
      caller, "stabiliser.set", fmt::format("{} sets {} to {:g} degC", caller.name, device, degc),
      {}, {"stabiliser " + device, "", fmt::format("{:g} degC", degc)});
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(recording));
  auto set = co_await bench_.set_point(i, degc);
  if (!set)
    events_.record_own("stabiliser.set_failed",
                       fmt::format("{} was not set to {:g} degC for {}: {}", device, degc,
                                   caller.name, set.error().message));
  co_return set;
}

Result<std::size_t> ManualControlService::stabiliser_named(const std::string& device) const {
  std::string known;
  for (const auto i : bench_.with_role(DeviceRole::stabiliser)) {
    const std::string& id = bench_.description(i).id;
    if (id == device) return i;
    known += (known.empty() ? "" : ", ") + id;
  }
  return fail(ErrorCode::not_found, reasons::kNoStabiliser,
              fmt::format("the cell has no stabiliser '{}', {}", device,
                          known.empty() ? "nor any other" : "it has " + known));
}

Awaitable<Result<DeclaredTuning>> ManualControlService::stabiliser_tuning(std::string device) {
  DRIFTWISE_CO_TRY(const auto i, stabiliser_named(device));
  DeclaredTuning tuning;
  DRIFTWISE_CO_TRY(tuning.now, co_await bench_.tuning(i));
  tuning.declared = bench_.declared_tuning(i);
  co_return tuning;
}

Awaitable<Result<TunedStabiliser>> ManualControlService::tune_stabiliser(Caller caller,
                                                                         std::string lease_token,
                                                                         std::string device,
                                                                         LoopTuning wanted) {
  DRIFTWISE_CO_RETURN_IF_ERROR(leases_.check(lease_token, clock_.now().utc));
  DRIFTWISE_CO_TRY(const auto i, stabiliser_named(device));
  if (wanted.empty())
    co_return fail(ErrorCode::invalid_argument, reasons::kMissingValue,
                   fmt::format("stabiliser '{}': found nothing to set, expected a band, the "
                               "integral or the derivative",
                               device));
  TunedStabiliser tuned;
  DRIFTWISE_CO_TRY(tuned.before, co_await bench_.tuning(i));
  auto after = co_await bench_.set_tuning(i, std::move(wanted));
  // What a refusal half way has changed is on record too.
  auto now = after ? after : co_await bench_.tuning(i);
  if (now && (after || *now != tuned.before))
    events_.record(caller, "stabiliser.tuned",
                   fmt::format("{} tuned {}: {} (before: {})", caller.name, device,
                               tuning_text(*now), tuning_text(tuned.before)),
                   {}, {"stabiliser " + device, tuning_text(tuned.before), tuning_text(*now)});
  DRIFTWISE_CO_RETURN_IF_ERROR(after);
  tuned.after = std::move(*after);
  co_return tuned;
}

}  // namespace driftwise::application
