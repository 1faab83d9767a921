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
#include "server/application/runs/passages.h"
#include "server/application/runs/recovery.h"
#include "server/application/runs/reference_record.h"
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
  before_ = std::move(before);
  may_start_ = asked_for;
  switch_on_ = asked_for && announce.empty() ? SwitchOn::yes : SwitchOn::if_unreferenced;
  begins_by_itself_ = std::move(announce);
  make_run(std::move(record), std::move(plan), std::move(trajectory));
  tasks_.spawn(execute());
}

void RunEngine::begin_unread(RunRecord record, Error why, ReadBasis read) {
  assert(!run_);
  before_.reset();
  may_start_ = false;
  switch_on_ = SwitchOn::if_unreferenced;
  begins_by_itself_.clear();
  read_basis_ = std::move(read);
  make_run(std::move(record), {}, {});
  auto& run = *run_;
  run.unread = true;
  if (run.record.state == RunState::paused)  // whoever paused it resumes it
    run.control.hold(stored_hold(run.record, bench_.clock.now().utc));
  else
    ask_to_mend(run, why);
  run.record.hold = {};  // in force again as soon as the engine stands
  tasks_.spawn(execute());
}

void RunEngine::make_run(RunRecord record, RunPlan plan, Trajectory trajectory) {
  run_ = std::make_unique<ActiveRun>(executor_, bench_, std::move(record), std::move(plan),
                                     std::move(trajectory));
  auto& run = *run_;
  had_datum_ = before_ && !before_->data.empty();
  stands_ = computer_was_away_ = false;
  referenced_.reset();
  recalls_reference_ = true;
  announcement_.clear();
  outlook_.begin_anew();
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
  bench_.lag.start_again();
  bench_.recorder.lend_pose_instruments(true);
  Result<void> outcome;
  if (read_basis_) outcome = co_await stand_unread();
  read_basis_ = {};
  auto& run = *run_;  // another one than before, where it stood
  if (outcome) outcome = co_await take_up(run);
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
  if (recalls_reference_)
    referenced_ =
        co_await kept_reference(bench_.writer, run.record.created, bench_.clock.now().utc);
  // A run that begins, or whose daemon ended before it looked: the axes as they are found.
  const bool has_tried = run.record.accepted + run.record.given_up > 0;
  if (!referenced_ && (may_start_ || !has_tried)) {
    const auto state = co_await bench_.devices.motion_state();
    if (state) co_await note_reference(state->referenced);
  }
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

Awaitable<Result<void>> RunEngine::walk(ActiveRun& run) {
  if (auto ok = co_await heed_hold(run); !ok) co_return ok;
  if (auto ok = co_await reach_datum(run); !ok) co_return ok;
  while (true) {
    if (!wanted_datum_) take_back_permission();
    if (return_is_owed(run))
      if (auto ok = co_await return_to_zero(run); !ok) co_return ok;
    const auto visit = next_visit(run.trajectory, run.record.place);
    if (!visit) break;
    if (auto ok = run.control.check(); !ok) co_return ok;
    if (run.control.held()) {
      if (auto ok = co_await mark_held(run); !ok) co_return ok;
      if (run.control.wants_zero())
        if (auto ok = co_await go_to_zero(run, "zero while the run waits"); !ok) co_return ok;
      if (auto ok = co_await heed_hold(run); !ok) co_return ok;
    }
    if (auto ok = co_await reach_datum(run); !ok) co_return ok;
    const auto& row = run.trajectory.points[static_cast<std::size_t>(visit->row)];
    run.progress.row = visit->row;
    run.progress.line = row.line;
    if (auto ok = co_await bring_force(run); !ok) co_return ok;
    if (run.control.held()) continue;  // since: weights may take hours
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
  }
  if (auto ok = co_await mark_held(run); !ok) co_return ok;
  co_return co_await mark_doubted(run);
}

// Not while a datum is wanted: what was measured counts from none that could be found again.
bool RunEngine::return_is_owed(const ActiveRun& run) const {
  return run.datum && !wanted_datum_ &&
         return_to_zero_is_owed(run.trajectory, run.record.place, run.since_return);
}

// Everything that hangs on the end-effector is taken off, and the axes return to zero.
Awaitable<Result<void>> RunEngine::park(ActiveRun& run) {
  if (!run.plan.rules.park) co_return Result<void>{};
  if (auto ok = co_await heed_hold(run); !ok) co_return ok;
  take_back_permission();
  if (auto ok = run.control.check(); !ok) co_return ok;
  if (bench_.description.load) {
    if (auto ok = co_await bench_.loading.look(bench_.devices); !ok) co_return ok;
    const auto acts_n = bench_.loading.known_n();
    if (acts_n && !same_force(*acts_n, 0))
      if (auto ok = co_await bench_.loading.bring_to(run.scope, 0); !ok) co_return ok;
    if (auto ok = co_await heed_hold(run); !ok) co_return ok;
    take_back_permission();
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

// The datum that is wanted, if one is, and what comes before it. Who pauses the run while it waits,
// for the minute that announces a motion or for weights, is heard before anything moves.
Awaitable<Result<void>> RunEngine::reach_datum(ActiveRun& run) {
  while (wanted_datum_) {
    if (auto ok = co_await heed_hold(run); !ok) co_return ok;
    if (auto ok = co_await prepare(run); !ok) co_return ok;
    if (auto ok = co_await clear_to_move(run); !ok) co_return ok;
    if (run.control.held()) continue;
    if (auto ok = co_await bring_force(run); !ok) co_return ok;
    if (run.control.held()) continue;
    if (auto ok = co_await new_datum(run); !ok) co_return ok;
  }
  co_return Result<void>{};
}

// Leaves the datum wanted where the run is held before the axes move.
Awaitable<Result<void>> RunEngine::new_datum(ActiveRun& run) {
  bench_.doubts.forget_datum();  // what the instruments show counts from elsewhere
  // Weights that a person hangs may take hours: the power may have gone meanwhile.
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await clear_to_move(run));
  if (run.control.held()) co_return Result<void>{};
  auto homing = make_homed(run.scope, wanted_datum_->home, switch_on_);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(homing));
  switch_on_ = SwitchOn::no;
  co_await note_reference(true);
  auto wanted = *wanted_datum_;
  wanted.home = false;  // it was done
  auto opening = open_datum(run.scope, std::move(wanted));
  DRIFTWISE_CO_TRY(auto datum, co_await std::move(opening));
  run.datum = std::move(datum);
  note_zeroing(run);
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

// On record at once: a daemon that is started anew tells a loss of power by it.
Awaitable<void> RunEngine::note_reference(bool referenced) {
  if (std::exchange(referenced_, referenced) == std::optional(referenced)) co_return;
  auto keeping =
      keep_reference(bench_.writer, bench_.clock.now().utc, ++reference_notes_, referenced);
  co_await std::move(keeping);
}

// Points that were measured while a limit of the cell was exceeded.
Awaitable<Result<void>> RunEngine::mark_held(ActiveRun& run) {
  for (const auto& mark : hooks_.hold_marks()) {
    auto rows = run.since_closure.take_from(mark.since, mark.until);
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await mark_rows(run, std::move(rows), mark.reason));
  }
  co_return Result<void>{};
}

// Once a line, where it grew by more than a poll: a kill must not take the largest lag along.
Awaitable<Result<void>> RunEngine::store_lag(ActiveRun& run) {
  constexpr double kWorthACommit_s = 0.1;
  if (bench_.lag.largest_s() < run.record.max_lag_s + kWorthACommit_s) co_return Result<void>{};
  run.record.max_lag_s = bench_.lag.largest_s();
  co_return co_await store_state(run);
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
  if (!outcome) static_cast<void>(co_await mark_held(run));
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
  run.progress.outlook = over || run.unread ? Outlook{} : outlook_.of(run, now, hooks_.look_ahead);
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
