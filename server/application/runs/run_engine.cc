#include "server/application/runs/run_engine.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <cassert>
#include <cmath>

#include "server/application/motion/loading.h"
#include "server/application/motion/motion.h"
#include "server/application/motion/start_checks.h"
#include "server/application/motion/stop_desk.h"
#include "server/application/plumbing/task_group.h"
#include "server/application/ports/run_hold.h"
#include "server/application/recording/doubts.h"
#include "server/application/runs/recovery.h"
#include "server/application/runs/run_state_store.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/core/units.h"

namespace driftwise::application {

RunEngine::RunEngine(asio::any_io_executor executor, Workbench& bench, Hooks hooks,
                     TaskGroup& tasks)
    : executor_(executor), bench_(bench), hooks_(std::move(hooks)), tasks_(tasks) {}

RunEngine::~RunEngine() = default;

void RunEngine::begin(RunRecord record, RunPlan plan, Trajectory trajectory,
                      std::optional<RunBefore> before, bool asked_for, std::string announce) {
  assert(!run_);
  run_ = std::make_unique<ActiveRun>(executor_, bench_, std::move(record), std::move(plan),
                                     std::move(trajectory));
  before_ = std::move(before);
  auto& run = *run_;
  may_start_ = asked_for;
  had_datum_ = before_ && !before_->data.empty();
  stands_ = computer_was_away_ = false;
  announcement_.clear();
  outlook_.begin_anew();
  begins_by_itself_ = std::move(announce);
  counted_accepted_ = run.record.accepted;
  counted_given_up_ = run.record.given_up;
  run.continued = before_.has_value();
  run.scope.phase = [this](std::string phase) {
    run_->progress.phase = std::move(phase);
    publish();
  };
  run.scope.enter_waiting = [this](std::string why) {
    return change(*run_, RunState::waiting, std::move(why));
  };
  run.scope.leave_waiting = [this] { return change(*run_, RunState::running, ""); };
  hooks_.look_at_cell(run.control);
  use_setup(run);
  if (shutting_down_) run.control.shut_down();
  tasks_.spawn(execute());
}

// The set-up stays in use after the run: what was zeroed with it counts from this datum.
void RunEngine::use_setup(const ActiveRun& run) {
  const auto& setups = bench_.description.setups;
  const auto found = std::ranges::find(setups, run.plan.setup, &SetupDescription::name);
  const auto* setup = found == setups.end() ? nullptr : &*found;
  bench_.devices.use(setup);
  bench_.pose.use(setup);
}

Awaitable<void> RunEngine::execute() {
  auto& run = *run_;
  bench_.lag.start_again();
  bench_.recorder.lend_pose_instruments(true);
  Result<void> outcome = co_await take_up(run);
  if (outcome) outcome = check_setup(bench_.description, run.plan.setup);
  if (outcome) outcome = co_await carry_out(run);
  co_await finish(run, outcome);
  bench_.recorder.lend_pose_instruments(false);
  // Whoever was told that the run is over may begin the next one at once.
  const auto ended = std::move(run_);
  publishing_ = false;
  watchers_.publish(*last_progress_);
}

// Makes the run's record say that it runs, and what became of it while the daemon was away.
Awaitable<Result<void>> RunEngine::take_up(ActiveRun& run) {
  wanted_datum_ = DatumOpening{"start", false, true, {}, {}};
  const bool was_paused = run.record.state == RunState::paused;
  if (was_paused) run.control.hold(stored_hold(run.record, bench_.clock.now().utc));
  run.record.hold = {};  // in force again as soon as the engine stands
  computer_was_away_ = !run.record.boot_id.empty() && !bench_.boot_id.empty() &&
                       run.record.boot_id != bench_.boot_id;
  const auto state = was_paused ? RunState::paused : RunState::running;
  auto reason = was_paused ? run.record.reason : std::string();
  bench_.doubts.begin_anew();
  bench_.doubts.forget_datum();
  static_cast<void>(bench_.doubts.take_suspicion());  // of before the run
  if (!before_) {
    run.record.started = bench_.clock.now().utc;
    run.meter.begin(run.record.started);
    bench_.events.record_own(
        "run.started",
        fmt::format("run {} '{}': {} rows", run.record.id.value, run.record.name, run.record.rows),
        run.record.id);
    co_return co_await change(run, state, std::move(reason));
  }
  for (const auto& attempt : before_->attempts) {
    auto& number = run.attempts_of_row[attempt.row];
    number = std::max(number, attempt.number);
  }
  for (const auto& closure : before_->closures)
    if (closure.decision == ClosureDecision::repeated) ++run.repetitions[closure.line];
  if (before_->meter) run.meter = *before_->meter;
  run.meter.begin(bench_.clock.now().utc);
  const std::string what = computer_was_away_ ? "restart of the computer"
                           : before_->killed  ? "restart after a kill"
                                              : "restart";
  wanted_datum_ = continue_from(bench_.description, what, *this->before_);
  ++run.record.restarts;
  bench_.events.record_own("run.restarted",
                           fmt::format("{}: row {} is next", what, run.record.place.next_row + 1),
                           run.record.id);
  if (before_->killed)
    if (auto ok = co_await record_interruption(run); !ok) co_return ok;
  co_return co_await change(run, state, std::move(reason));
}

Awaitable<Result<void>> RunEngine::carry_out(ActiveRun& run) {
  int troubles_in_a_row = 0;
  while (true) {
    const auto attempts_before = run.record.accepted + run.record.given_up;
    Result<void> outcome = co_await walk(run);
    if (outcome) outcome = co_await park(run);
    if (outcome) co_return outcome;
    troubles_in_a_row =
        run.record.accepted + run.record.given_up > attempts_before ? 1 : troubles_in_a_row + 1;
    const Error trouble = outcome.error();
    do {
      // What a device says about being stopped matters less than who wanted it.
      if (run.control.halted()) {
        outcome = co_await stand_still(run, trouble);
      } else if (auto ok = run.control.check(); !ok) {
        co_return ok;
      } else {
        outcome = co_await overcome(run, trouble, troubles_in_a_row);
      }
    } while (!outcome && run.control.halted());  // stopped while it waited
    if (!outcome) co_return outcome;
  }
}

// Until a person resumes, or the condition is over; then the devices are looked at as after any
// trouble.
Awaitable<Result<void>> RunEngine::stand_still(ActiveRun& run, const Error& trouble) {
  if (auto ok = co_await wait_until_stopped(run); !ok) co_return ok;
  const bool by_person = run.control.hold().kind != RunHold::Kind::condition;
  // An axis that cannot be reached stands by its own watchdog.
  if (!by_person) static_cast<void>(co_await bench_.devices.stop());
  if (auto ok = co_await mark_held(run); !ok) co_return ok;
  if (auto ok = co_await hold(run, RunState::paused); !ok) co_return ok;
  co_return co_await look_again(run, remedy_for(trouble), by_person);
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

Awaitable<Result<void>> RunEngine::walk(ActiveRun& run) {
  if (run.control.held()) {
    const auto kind = run.control.hold().kind;
    const auto state = kind == RunHold::Kind::configuration ? RunState::waiting : RunState::paused;
    if (auto ok = co_await hold(run, state); !ok) co_return ok;
  }
  if (wanted_datum_) {
    if (auto ok = co_await prepare(run); !ok) co_return ok;
    if (auto ok = co_await clear_to_move(run); !ok) co_return ok;
    if (auto ok = co_await bring_force(run); !ok) co_return ok;
    if (auto ok = co_await new_datum(run); !ok) co_return ok;
  }
  while (const auto visit = next_visit(run.trajectory, run.record.place)) {
    if (auto ok = run.control.check(); !ok) co_return ok;
    if (run.control.held()) {
      if (auto ok = co_await mark_held(run); !ok) co_return ok;
      if (run.control.wants_zero())
        if (auto ok = co_await go_to_zero(run, "zero while the run waits"); !ok) co_return ok;
      if (auto ok = co_await hold(run, RunState::paused); !ok) co_return ok;
    }
    if (wanted_datum_) {
      if (auto ok = co_await prepare(run); !ok) co_return ok;
      if (auto ok = co_await bring_force(run); !ok) co_return ok;
      if (auto ok = co_await new_datum(run); !ok) co_return ok;
    }
    const auto& row = run.trajectory.points[static_cast<std::size_t>(visit->row)];
    run.progress.row = visit->row;
    run.progress.line = row.line;
    if (auto ok = co_await bring_force(run); !ok) co_return ok;
    run.meter.visit_begins(bench_.clock.now().utc);
    DRIFTWISE_CO_TRY(auto result, co_await visit_row(run, *visit, hooks_.command_for));
    run.meter.visited(visit->from_queue, run.length.row(visit->row), bench_.clock.now().utc);
    if (result.point) run.since_closure.add(visit->row, result.point->measured.utc);
    run.since_return.add(visit->row, result.verdict);
    if (auto ok = co_await mark_doubted(run); !ok) co_return ok;
    if (auto ok = co_await mark_held(run); !ok) co_return ok;
    if (result.point && row.zero) {
      auto noting = note_closure(run, result.point->values, result.point->measured, row.line);
      if (auto ok = co_await std::move(noting); !ok) co_return ok;
      if (auto ok = co_await store_lag(run); !ok) co_return ok;
    }
    publish();
    if (result.verdict == Verdict::given_up) hold_if_too_many_were_given_up(run);
    if (return_to_zero_is_due(run.trajectory, run.record.place, visit->row))
      if (auto ok = co_await return_to_zero(run, row.line); !ok) co_return ok;
  }
  co_return co_await mark_doubted(run);
}

// Everything that hangs on the end-effector is taken off, and the axes return to zero.
Awaitable<Result<void>> RunEngine::park(ActiveRun& run) {
  if (!run.plan.rules.park) co_return Result<void>{};
  if (run.control.held())
    if (auto ok = co_await hold(run, RunState::paused); !ok) co_return ok;
  if (auto ok = run.control.check(); !ok) co_return ok;
  if (bench_.description.load) {
    if (auto ok = co_await bench_.loading.look(bench_.devices); !ok) co_return ok;
    const auto acts_n = bench_.loading.known_n();
    if (acts_n && !same_force(*acts_n, 0))
      if (auto ok = co_await bench_.loading.bring_to(run.scope, 0); !ok) co_return ok;
  }
  const std::vector<double> zero_mm(bench_.description.motor_channels().size(), 0.0);
  if (!check_soft_limits(bench_.description, zero_mm)) co_return Result<void>{};
  DRIFTWISE_CO_TRY(const auto state, co_await bench_.devices.motion_state());
  bool is_there = true;
  for (const double q_mm : state.q_mm)
    is_there = is_there && std::abs(nm_from_mm(q_mm)) <= run.plan.rules.in_position_nm;
  if (is_there) co_return Result<void>{};
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await go_to(run.scope, zero_mm, "parked"));
  co_return Result<void>{};
}

void RunEngine::hold_if_too_many_were_given_up(ActiveRun& run) {
  const auto given_up = run.record.given_up - counted_given_up_;
  const auto decided = run.record.accepted - counted_accepted_ + given_up;
  const double share = run.plan.rules.max_given_up_share;
  const bool is_too_many = static_cast<double>(given_up) > share * static_cast<double>(decided);
  if (share >= 1 || given_up < RunRules::kLeastGivenUp || !is_too_many) return;
  run.control.hold({RunHold::Kind::trouble, "", bench_.clock.now().utc,
                    fmt::format("{} of the last {} rows were given up, the limit is {:.0f} % "
                                "(max_given_up_share): 'driftwise run attempts {}' says why",
                                given_up, decided, 100 * share, run.record.id.value)});
  counted_accepted_ = run.record.accepted;
  counted_given_up_ = run.record.given_up;
}

void RunEngine::take_metadata(RunId run, RunMetadata metadata) {
  if (!run_ || run_->record.id != run) return;
  run_->record.metadata = std::move(metadata);
  publish();
}

void RunEngine::remeasure_zero(std::string reason) {
  if (!run_ || wanted_datum_) return;  // one that is wanted already measures the zero too
  wanted_datum_ = DatumOpening{std::move(reason), false, false, run_->datum, run_->closures};
}

Awaitable<Result<void>> RunEngine::prepare(ActiveRun& run) {
  run.scope.phase("checking");
  if (auto ok = co_await bench_.devices.prepare_for_run(); !ok) co_return ok;
  co_return co_await check_thermometers(run.scope);
}

// What the next row wants to act; nothing when it does not say.
Awaitable<Result<void>> RunEngine::bring_force(ActiveRun& run) {
  const auto visit = next_visit(run.trajectory, run.record.place);
  if (!visit || !bench_.description.load) co_return Result<void>{};
  const auto wanted_n = run.trajectory.points[static_cast<std::size_t>(visit->row)].force_n;
  if (!wanted_n) co_return co_await bench_.loading.look(bench_.devices);
  co_return co_await bench_.loading.bring_to(run.scope, *wanted_n);
}

Awaitable<Result<void>> RunEngine::new_datum(ActiveRun& run) {
  DRIFTWISE_CO_TRY(auto datum, co_await open_datum(run.scope, *wanted_datum_));
  run.datum = std::move(datum);
  run.closures.clear();
  if (const auto before = std::exchange(before_, std::nullopt)) add_line_under_way(run, *before);
  if (auto ok = co_await mark_after_datum(run); !ok) co_return ok;
  had_datum_ = true;
  wanted_datum_.reset();
  hooks_.datum_opened(*run.datum);
  run.closure_judge.begin(zero_of_datum(run));  // a model is anchored in the datum by now
  run.since_return.begin(run.record.place, run.record.given_up);
  run.jumped_nm.clear();
  co_return Result<void>{};
}

// Points that were measured while a limit of the cell was exceeded.
Awaitable<Result<void>> RunEngine::mark_held(ActiveRun& run) {
  for (const auto& mark : hooks_.hold_marks()) {
    auto rows = run.since_closure.take_from(mark.since);
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await mark_rows(run, std::move(rows), mark.reason));
  }
  co_return Result<void>{};
}

Awaitable<Result<void>> RunEngine::go_to_zero(ActiveRun& run, std::string why) {
  const std::vector<double> zero_mm(bench_.description.motor_channels().size(), 0.0);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await go_to(run.scope, zero_mm, std::move(why)));
  co_return Result<void>{};
}

Awaitable<Result<void>> RunEngine::return_to_zero(ActiveRun& run, std::int64_t line) {
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await go_to_zero(run, fmt::format("zero after line {}", line)));
  Stamp measured;
  DRIFTWISE_CO_TRY(auto values, co_await read_zero(run, measured));
  auto noting = note_closure(run, std::move(values), measured, line);
  if (auto ok = co_await std::move(noting); !ok) co_return ok;
  co_return co_await store_lag(run);
}

// Once a line, where it grew by more than a poll: a kill must not take the largest lag along.
Awaitable<Result<void>> RunEngine::store_lag(ActiveRun& run) {
  constexpr double kWorthACommit_s = 0.1;
  if (bench_.lag.largest_s() < run.record.max_lag_s + kWorthACommit_s) co_return Result<void>{};
  run.record.max_lag_s = bench_.lag.largest_s();
  co_return co_await store_state(run);
}

Awaitable<Result<void>> RunEngine::overcome(ActiveRun& run, const Error& error,
                                            int troubles_in_a_row) {
  constexpr int kPatience = 5;
  auto remedy = remedy_for(error);
  if (remedy == Remedy::leave || remedy == Remedy::abort || remedy == Remedy::fail)
    co_return tl::unexpected(error);
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
  co_return co_await look_again(run, remedy, remedy == Remedy::hold);
}

// asked_for: a person has said just now that the robot may move.
Awaitable<Result<void>> RunEngine::look_again(ActiveRun& run, Remedy remedy, bool asked_for) {
  DRIFTWISE_CO_TRY(const auto recovery, co_await wait_for_devices(run.scope));
  if (recovery.reference_lost && had_datum_ && !asked_for) may_start_ = false;  // power was away
  const bool beam_lost = recovery.beam_lost || remedy == Remedy::new_datum;
  if (beam_lost || recovery.reference_lost)
    wanted_datum_ =
        DatumOpening{beam_lost ? "beam lost" : "reference lost", recovery.reference_lost, false,
                     beam_lost ? std::nullopt : run.datum, run.closures};
  co_return co_await change(run, RunState::running, "");
}

Awaitable<Result<void>> RunEngine::hold(ActiveRun& run, RunState state) {
  // Meanwhile the recorder shows where the axes and the lengths are, and a person may move them.
  bench_.recorder.lend_pose_instruments(false);
  Result<void> may_continue = run.control.check();
  while (may_continue && run.control.held()) {
    const bool by_itself = run.control.hold().kind == RunHold::Kind::condition;
    // A person's time is nobody's to foresee; a cell's waits are.
    if (by_itself)
      run.meter.let_go(bench_.clock.now().utc);
    else
      run.meter.keep(bench_.clock.now().utc);
    if (run.record.hold != run.control.hold()) {  // the first, or one that came on top of it
      run.record.hold = run.control.hold();
      const auto now = by_itself ? RunState::waiting : state;
      may_continue = co_await change(run, now, run.record.hold.reason);
      run.scope.phase(by_itself                 ? "waiting for the cell"
                      : now == RunState::paused ? "paused"
                                                : "waiting for a person");
    } else {
      stands_ = !by_itself;  // it may go on at any moment: nobody moves the axes meanwhile
      may_continue = co_await wait_for_change(run);
      stands_ = false;
    }
    if (may_continue && !run.control.held()) hooks_.look_at_cell(run.control);
    if (may_continue) may_continue = run.control.check();
  }
  run.meter.let_go(bench_.clock.now().utc);
  bench_.recorder.lend_pose_instruments(true);
  if (!may_continue) co_return may_continue;
  // Whoever ended it has said that the robot may move; who accepted a cell file has not, nor has a
  // cell that is within its limits again.
  if (run.record.hold.kind != RunHold::Kind::configuration &&
      run.record.hold.kind != RunHold::Kind::condition)
    may_start_ = true;
  run.record.hold = {};
  co_return co_await change(run, RunState::running, "");
}

Awaitable<Result<void>> RunEngine::change(ActiveRun& run, RunState state, std::string reason) {
  run.record.state = state;
  run.record.reason = std::move(reason);
  run.record.max_lag_s = std::max(run.record.max_lag_s, bench_.lag.largest_s());
  publish();
  co_return co_await store_state(run);
}

Awaitable<void> RunEngine::finish(ActiveRun& run, const Result<void>& outcome) {
  const auto remedy = outcome ? Remedy::abort : remedy_for(outcome.error());
  if (!outcome) static_cast<void>(co_await bench_.devices.stop());
  if (!outcome) static_cast<void>(co_await mark_doubted(run));
  if (!outcome && remedy == Remedy::leave) {
    adopt_pause(run);
    const auto state = run.record.state == RunState::paused ? RunState::paused : RunState::waiting;
    const auto reason =
        state == RunState::paused ? run.record.reason : std::string(kShutDownReason);
    static_cast<void>(co_await change(run, state, reason));
    run.progress.phase = "ended with the daemon";
    publish();
    co_return;
  }
  run.record.hold = {};
  run.record.ended = bench_.clock.now().utc;
  if (outcome) run.meter.end(run.record.ended);
  hooks_.measured(run.meter.steps());
  const auto state = outcome                   ? RunState::done
                     : remedy == Remedy::abort ? RunState::aborted
                                               : RunState::failed;
  auto reason = outcome ? std::string() : outcome.error().message;
  auto stored = co_await change(run, state, std::move(reason));
  if (!stored)
    spdlog::error("the end of run {} is not stored: {}", run.record.id.value,
                  stored.error().message);
  bench_.events.record_own(
      fmt::format("run.{}", to_string(state)),
      outcome ? fmt::format("{} points accepted, {} given up, largest lag {:.2f} s",
                            run.record.accepted, run.record.given_up, run.record.max_lag_s)
              : outcome.error().message,
      run.record.id);
  run.progress.phase = std::string(to_string(state));
  publish();
}

std::optional<Outlook> RunEngine::outlook(CellTime now) const {
  return run_ ? outlook_.kept(*run_, now) : std::nullopt;
}

void RunEngine::publish() {
  auto& run = *run_;
  run.progress.run = run.record;
  run.progress.sequence = ++sequence_;
  run.progress.unstored = run.state_unstored;
  const bool over = is_over(run.record.state);
  const auto now = bench_.clock.now().utc;
  run.progress.outlook = over ? Outlook{} : outlook_.of(run, now, hooks_.look_ahead);
  run.progress.remaining_s = run.progress.outlook.expected_s;
  run.progress.estimated_end =
      over ? run.record.ended : now + nanoseconds_from_s(run.progress.remaining_s);
  last_progress_ = run.progress;
  // Several changes in one turn of the executor are told once, with the latest state.
  if (std::exchange(publishing_, true)) return;
  asio::post(executor_, [this] {
    if (std::exchange(publishing_, false)) watchers_.publish(*last_progress_);
  });
}

}  // namespace driftwise::application
