// The engine's waits in the middle of a run: after a trouble, a stop, a pause, a condition of the
// cell, and before a run whose plan cannot be read.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "server/application/motion/start_checks.h"
#include "server/application/motion/stop_desk.h"
#include "server/application/runs/passages.h"
#include "server/application/runs/recovery.h"
#include "server/application/runs/run_engine.h"
#include "server/application/runs/run_state_store.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::application {

namespace {

// Whoever ends it has said that the robot may move.
bool is_ended_by_a_person(RunHold::Kind kind) {
  return kind != RunHold::Kind::none && kind != RunHold::Kind::configuration &&
         kind != RunHold::Kind::condition;
}

}  // namespace

// Until a person resumes, or the condition is over; then the devices are looked at as after any
// trouble.
Awaitable<Result<void>> RunEngine::stand_still(ActiveRun& run, const Error& trouble) {
  take_back_permission();
  const bool by_cell = run.control.halted_by_cell();
  if (auto ok = co_await wait_until_stopped(run); !ok) co_return ok;
  // The cell stops the axes of the run, and none that are lent to a person. An axis that cannot be
  // reached stands by its own watchdog.
  if (by_cell && !axes_lent_) static_cast<void>(co_await bench_.devices.stop());
  if (auto ok = co_await mark_held(run); !ok) co_return ok;
  if (auto ok = co_await hold(run, RunState::paused); !ok) co_return ok;
  co_return co_await look_again(run, remedy_for(trouble));
}

// The stop itself is the desk's; the run is paused once the controllers have confirmed it.
Awaitable<Result<void>> RunEngine::wait_until_stopped(ActiveRun& run) {
  run.control.take_halt();
  bool told = false;
  while (bench_.stops.pending()) {
    auto unconfirmed = bench_.stops.unconfirmed();
    if (!unconfirmed.empty() && !std::exchange(told, true)) {
      run.scope.phase("stopping");
      auto reason = std::move(unconfirmed.front().sentence);
      if (auto ok = co_await change(run, RunState::waiting, std::move(reason)); !ok) co_return ok;
    }
    const double pause_s = std::max(0.1, 0.02 * bench_.clock.speed());
    co_await sleep_unless(bench_.clock, bench_.clock.now().utc + nanoseconds_from_s(pause_s),
                          run.control.changed());
    run.control.take_halt();  // pressed again
    if (auto ok = run.control.check(); !ok) co_return ok;
  }
  co_return Result<void>{};
}

Awaitable<Result<void>> RunEngine::overcome(ActiveRun& run, const Error& error,
                                            int troubles_in_a_row) {
  constexpr int kPatience = 5;
  auto remedy = remedy_for(error);
  // Behind a run that has measured there are hours that its next zero still confirms: it is tried
  // again, then a person is asked.
  if (error.reason == reasons::kZeroNotReached && had_datum_) remedy = Remedy::wait_for_device;
  if (remedy == Remedy::leave || remedy == Remedy::abort || remedy == Remedy::fail)
    co_return tl::unexpected(error);
  take_back_permission();
  run.scope.phase("waiting");
  // First of all: the mark may wait for the disk. An axis that cannot be reached stands by its own
  // watchdog.
  static_cast<void>(co_await bench_.devices.stop());
  if (auto ok = co_await mark_doubted(run); !ok) co_return ok;
  bench_.events.record_own("run.trouble", error.message, run.record.id);
  // A device that says what cannot be is waited for: it may be right again after hours. Weights
  // that stick are mended by a person, who need not know that a run waits for them.
  const bool by_weights = is_of_weights(error);
  if (troubles_in_a_row >= kPatience && remedy == Remedy::wait_for_device &&
      !is_device_loss(error) && error.reason != reasons::kImplausible && !by_weights)
    remedy = Remedy::hold;
  if (remedy == Remedy::hold) {
    run.control.hold({RunHold::Kind::trouble, "", bench_.clock.now().utc, error.message});
    if (auto ok = co_await hold(run, RunState::waiting); !ok) co_return ok;
  } else if (auto ok = co_await change(run, RunState::waiting, error.message); !ok) {
    co_return ok;
  }
  if (by_weights) {
    constexpr double kLongest_s = 30;
    const double pause_s = std::min(kLongest_s, 2.0 * troubles_in_a_row);
    if (auto ok = co_await run.scope.sleep_s(pause_s); !ok) co_return ok;
  }
  // Where only the next move shows it, it is not tried all the time: each is an alarm.
  if (error.reason == reasons::kImplausible && troubles_in_a_row > 1) {
    constexpr double kFirst_s = 5, kLongest_s = 600;
    const double pause_s = std::min(kLongest_s, kFirst_s * std::exp2(troubles_in_a_row - 1));
    if (auto ok = co_await run.scope.sleep_s(pause_s); !ok) co_return ok;
  }
  co_return co_await look_again(run, remedy);
}

// Whoever ended a hold has asked for motion of the machine as it stood then. The end of a wait is
// nobody's to foresee: a servo that is off by then may have been switched off during it.
Awaitable<Result<void>> RunEngine::look_again(ActiveRun& run, Remedy remedy) {
  DRIFTWISE_CO_TRY(const auto recovery, co_await wait_for_devices(run.scope));
  if (recovery.waited) take_back_permission();
  const bool asked_for = switch_on_ == SwitchOn::yes;
  const bool power_was_away = !asked_for && has_lost_reference(!recovery.reference_lost);
  if (asked_for || !recovery.reference_lost) co_await note_reference(!recovery.reference_lost);
  if (!asked_for && !recovery.reference_lost) switch_on_ = SwitchOn::no;
  // Before weights move as well. Where power was away the cell file says who is asked.
  const bool was_switched_off = recovery.servo_off && !power_was_away && switch_on_ == SwitchOn::no;
  if (was_switched_off) co_return co_await overcome(run, servo_is_off(), 1);
  if (power_was_away) may_start_ = false;
  if (!recovery.servo_off) take_back_permission();
  co_await note_stand(run);
  want_datum(run, recovery.beam_lost || remedy == Remedy::new_datum, recovery.reference_lost,
             recovery.servo_off);
  co_return co_await change(run, RunState::running, "");
}

// What is wanted already keeps its terms: why, what it is compared with, whether the drift is
// checked and the axes are homed. What is lost on top of that is added.
void RunEngine::want_datum(const ActiveRun& run, bool beam_lost, bool reference_lost,
                           bool servo_off) {
  if (!beam_lost && !reference_lost && !servo_off) return;
  if (!wanted_datum_)
    wanted_datum_ = DatumOpening{beam_lost        ? "beam lost"
                                 : reference_lost ? "reference lost"
                                                  : "servo off",
                                 false, false, run.datum, run.closures};
  wanted_datum_->home = wanted_datum_->home || reference_lost;
  if (beam_lost) wanted_datum_->before.reset();
}

// Of axes without a reference when it was given what is left is the permission of a run that begins
// by itself, until a homing has succeeded: they come so from their power supply, and nobody has
// switched them off.
void RunEngine::take_back_permission() {
  if (switch_on_ != SwitchOn::yes) return;
  const bool was_without = referenced_ == std::optional(false);
  switch_on_ = was_without ? SwitchOn::if_unreferenced : SwitchOn::no;
}

// Axes that nobody has seen without a reference count as referenced before.
bool RunEngine::has_lost_reference(bool referenced) const {
  return !referenced && referenced_ != std::optional(false);
}

// A servo that is off right after a person has asked for motion was off when they asked: the datum
// that follows switches it on. One that is on needs no permission, and keeps none for later.
Awaitable<Result<void>> RunEngine::use_permission(ActiveRun& run) {
  if (switch_on_ != SwitchOn::yes) co_return Result<void>{};
  DRIFTWISE_CO_TRY(const auto state, co_await bench_.devices.motion_state());
  co_await note_reference(state.referenced);
  want_datum(run, false, !state.referenced, !state.servo_on);
  if (state.servo_on) take_back_permission();
  co_return Result<void>{};
}

// What holds the run, if anything does, until it is over.
Awaitable<Result<void>> RunEngine::heed_hold(ActiveRun& run) {
  if (!run.control.held()) co_return Result<void>{};
  const auto kind = run.control.hold().kind;
  const auto state = kind == RunHold::Kind::configuration ? RunState::waiting : RunState::paused;
  if (auto ok = co_await hold(run, state); !ok) co_return ok;
  co_return co_await use_permission(run);
}

// A person has resumed, and the cell still keeps the run. That the robot may move is said, of the
// machine as it stands now: also that its power was away. A servo that is off when the cell lets go
// may have been switched off meanwhile.
Awaitable<void> RunEngine::take_resume(ActiveRun& run) {
  may_start_ = true;
  begins_by_itself_.clear();
  switch_on_ = SwitchOn::yes;
  static_cast<void>(co_await use_permission(run));  // a controller that is silent: asked again
  take_back_permission();
}

Awaitable<Result<void>> RunEngine::hold(ActiveRun& run, RunState state) {
  const auto begun = run.control.hold().kind;
  if (run.control.held() || axes_lent_) {
    take_back_permission();
    co_await note_stand(run);  // a person may move the axes from there
  }
  // Meanwhile the recorder shows where the axes and the lengths are, and a person may move them.
  bench_.recorder.lend_pose_instruments(false);
  bool is_resumed = false;  // by a person, and the cell has not let go since
  Result<void> may_continue = run.control.check();
  while (may_continue && (run.control.held() || axes_lent_)) {
    if (run.control.held()) {
      const bool waits_for_a_person = is_ended_by_a_person(run.control.hold().kind);
      may_continue = co_await hold_on(run, state);
      is_resumed = waits_for_a_person && !is_ended_by_a_person(run.control.hold().kind);
    } else {
      // Whatever ended the hold: two sequences would drive the axes at once.
      run.scope.phase("waiting for the movement by hand");
      co_await run.control.changed().wait();
    }
    if (may_continue && !run.control.held() && !axes_lent_) hooks_.look_at_cell(run.control);
    const bool waits_for_the_cell = run.control.hold().kind == RunHold::Kind::condition;
    if (may_continue && waits_for_the_cell && std::exchange(is_resumed, false))
      co_await take_resume(run);
    if (may_continue) may_continue = run.control.check();
  }
  run.meter.let_go(bench_.clock.now().utc);
  bench_.recorder.lend_pose_instruments(true);
  if (!may_continue) co_return may_continue;
  // Who accepted a cell file has said nothing of motion, nor has a cell that is within its limits
  // again, nor anybody where nothing held the run.
  const auto on_record = std::exchange(run.record.hold, {}).kind;
  const auto ended = on_record == RunHold::Kind::none ? begun : on_record;  // none: at once
  if (is_ended_by_a_person(ended)) {
    may_start_ = true;
    begins_by_itself_.clear();
    switch_on_ = SwitchOn::yes;
  }
  co_await note_stand(run);
  co_return co_await change(run, RunState::running, "");
}

// One step of it: what holds the run goes on record, or is waited out until something changes.
Awaitable<Result<void>> RunEngine::hold_on(ActiveRun& run, RunState state) {
  const auto wanted = run.control.hold();
  const bool by_itself = wanted.kind == RunHold::Kind::condition;
  // A person's time is nobody's to foresee; a cell's waits are.
  if (by_itself)
    run.meter.let_go(bench_.clock.now().utc);
  else
    run.meter.keep(bench_.clock.now().utc);
  if (run.record.hold == wanted) {
    stands_ = true;
    auto changed = co_await wait_for_change(run);
    stands_ = false;
    co_return changed;
  }
  // The first, or one that came on top of it.
  run.record.hold = wanted;
  const bool of_person = wanted.kind == RunHold::Kind::pause || wanted.kind == RunHold::Kind::stop;
  const auto now = by_itself ? RunState::waiting : of_person ? RunState::paused : state;
  auto stored = co_await change(run, now, wanted.reason);
  run.scope.phase(by_itself                 ? "waiting for the cell"
                  : now == RunState::paused ? "paused"
                                            : "waiting for a person");
  co_return stored;
}

void RunEngine::lend_axes(bool lent) {
  axes_lent_ = lent;
  if (run_) run_->control.changed().raise();
}

void RunEngine::ask_to_mend(ActiveRun& run, const Error& why) {
  run.control.hold({RunHold::Kind::trouble, "", bench_.clock.now().utc,
                    fmt::format("run {} cannot be continued: {}: mend that, then resume the run, "
                                "or abort it",
                                run.record.id.value, why.message)});
}

// Until what the run goes by can be read, and a person has resumed it. Then another ActiveRun is in
// its place.
Awaitable<Result<void>> RunEngine::stand_unread() {
  const auto found = run_->record;
  while (true) {
    auto& run = *run_;
    auto held = co_await hold(run, RunState::waiting);
    while (!held && run.control.halted()) {
      held = co_await wait_until_stopped(run);
      if (held) held = co_await hold(run, RunState::waiting);
    }
    DRIFTWISE_CO_RETURN_IF_ERROR(held);
    auto reading = read_basis_();
    auto basis = co_await std::move(reading);
    DRIFTWISE_CO_RETURN_IF_ERROR(run.control.check());
    if (!basis) {
      ask_to_mend(run, basis.error());
      continue;
    }
    auto record = found;
    record.metadata = run.record.metadata;
    record.state = RunState::waiting;  // no longer paused
    record.hold = {};
    const auto wanted = run.control.hold();  // meanwhile
    before_ = std::move(basis->before);
    make_run(std::move(record), std::move(basis->plan), std::move(basis->trajectory));
    recalls_reference_ = switch_on_ != SwitchOn::yes;  // a person has asked since
    if (wanted.kind != RunHold::Kind::none && wanted.kind != RunHold::Kind::condition)
      run_->control.hold(wanted);
    co_return Result<void>{};
  }
}

}  // namespace driftwise::application
