#pragma once
// Executes one run at a time: checks, datum, points, returns to zero; waits out what devices, disk
// and people do to it; and goes on with a run that was under way when the daemon ended. Executor's
// thread.

#include <functional>
#include <memory>
#include <optional>

#include "server/application/plumbing/task_group.h"
#include "server/application/plumbing/watch_list.h"
#include "server/application/ports/alarm_condition.h"
#include "server/application/runs/active_run.h"
#include "server/application/runs/hold_mark.h"
#include "server/application/runs/point_visit.h"
#include "server/application/runs/run_outlook.h"
#include "server/application/runs/trouble.h"
#include "server/application/serving/model_pose.h"

namespace driftwise::application {

// What is known of a run that is gone on with, read from the store beforehand.
struct RunBefore {
  std::vector<AttemptRecord> attempts;
  std::vector<PointRecord> zeros;  // its accepted returns to zero
  std::vector<DatumRecord> data;
  std::vector<ClosureRecord> closures;
  bool killed = true;              // false: the daemon ended in good order
  std::optional<StepMeter> meter;  // what its rows took
};

// What a run goes by.
struct RunBasis {
  RunPlan plan;
  Trajectory trajectory;
  std::optional<RunBefore> before;
};
using ReadBasis = std::function<Awaitable<Result<RunBasis>>()>;

class RunEngine {
 public:
  struct Hooks {
    CommandFor command_for;                                // where a row is moved to
    std::function<void(const DatumRecord&)> datum_opened;  // serving anchors to it
    std::function<void(AlarmCondition)> alarm;             // something happened and is over at once
    std::function<void(RunControl&)> look_at_cell;         // sets what of the cell keeps a run now
    std::function<std::vector<HoldMark>()> hold_marks;     // the points that these mark, once
    std::function<Outlook(const RunAhead&)> look_ahead;    // by what runs of this cell took
    std::function<void(RunSteps)> measured;                // what this one took
    // The pose that the serving model gives for these conditions; none: no model answers.
    std::function<std::optional<ModelPose>(const std::vector<ChannelValue>&)> model_pose;
  };
  RunEngine(asio::any_io_executor executor, Workbench& bench, Hooks hooks, TaskGroup& tasks);
  ~RunEngine();

  // The run must not be over, and none may be under way. Returns at once. asked_for: a person has
  // asked for it just now; false: it was under way, or about to begin, when the daemon ended.
  // announce: why it begins by itself, told for a minute before its first motion; empty: a person
  // has asked for it.
  void begin(RunRecord record, RunPlan plan, Trajectory trajectory, std::optional<RunBefore> before,
             bool asked_for, std::string announce = {});

  // A run that was under way when the daemon ended, and that cannot be gone on with for this
  // reason: it stands until a person aborts it, or resumes it and `read` succeeds. Nothing of it is
  // lost.
  void begin_unread(RunRecord record, Error why, ReadBasis read);

  // Of the run under way, as the store has it now; of another one: nothing.
  void take_metadata(RunId run, RunMetadata metadata);

  // The run under way opens a new datum before its next point, without homing; none: nothing.
  void remeasure_zero(std::string reason);

  // The run under way ends as it stands, to go on after the next start; so does one that is begun
  // later, by a request that was on its way.
  void shut_down() {
    shutting_down_ = true;
    if (run_) run_->control.shut_down();
  }

  bool shutting_down() const { return shutting_down_; }

  // A movement by hand begins or is over: no run leaves a hold in between, whatever ends it.
  void lend_axes(bool lent);

  bool busy() const { return run_ != nullptr; }
  // The run under way waits for a person and does nothing meanwhile: the axes may be moved by hand.
  // Not from the instant on at which the hold was ended, and not while the cell alone keeps it: it
  // may go on at any moment then.
  bool stands() const {
    return run_ && stands_ && run_->control.held() &&
           run_->control.hold().kind != RunHold::Kind::condition;
  }
  // It has a datum, and none is to be opened before its next point.
  bool measures() const { return run_ && run_->datum && !wanted_datum_; }
  // Before a first motion that nobody asked for: a sentence for people; empty: none is ahead.
  const std::string& announcement() const { return announcement_; }
  RunControl* control() { return run_ ? &run_->control : nullptr; }
  const RunRecord* record() const { return run_ ? &run_->record : nullptr; }
  // The rules that it goes by, whatever the cell file says now; nullptr: there is no run.
  const RunRules* rules() const { return run_ ? &run_->plan.rules : nullptr; }
  // The run under way, else the last one that ended.
  const std::optional<RunProgress>& progress() const { return last_progress_; }
  // Of the run under way, with its draws; none: there is none.
  std::optional<Outlook> outlook(CellTime now) const;
  WatchList<RunProgress>& watchers() { return watchers_; }

 private:
  void make_run(RunRecord record, RunPlan plan, Trajectory trajectory);
  Awaitable<void> execute();
  Awaitable<Result<void>> carry_out(ActiveRun& run);
  Awaitable<Result<void>> prepare(ActiveRun& run);
  Awaitable<Result<void>> walk(ActiveRun& run);
  bool return_is_owed(const ActiveRun& run) const;
  Awaitable<Result<void>> park(ActiveRun& run);
  void hold_if_too_many_were_given_up(ActiveRun& run);
  Awaitable<Result<void>> bring_force(ActiveRun& run);
  Awaitable<Result<void>> reach_datum(ActiveRun& run);
  Awaitable<Result<void>> new_datum(ActiveRun& run);
  Awaitable<void> note_reference(bool referenced);
  Awaitable<Result<void>> mark_held(ActiveRun& run);
  Awaitable<Result<void>> change(ActiveRun& run, RunState state, std::string reason);
  Awaitable<Result<void>> store_lag(ActiveRun& run);
  Awaitable<void> finish(ActiveRun& run, const Result<void>& outcome);
  Awaitable<Result<void>> take_up(ActiveRun& run);
  // waiting.cc
  Awaitable<Result<void>> overcome(ActiveRun& run, const Error& error, int troubles_in_a_row);
  Awaitable<Result<void>> stand_still(ActiveRun& run, const Error& trouble);
  Awaitable<Result<void>> wait_until_stopped(ActiveRun& run);
  Awaitable<Result<void>> look_again(ActiveRun& run, Remedy remedy);
  void want_datum(const ActiveRun& run, bool beam_lost, bool reference_lost, bool servo_off);
  Awaitable<Result<void>> hold(ActiveRun& run, RunState state);
  Awaitable<Result<void>> hold_on(ActiveRun& run, RunState state);
  Awaitable<Result<void>> heed_hold(ActiveRun& run);
  Awaitable<void> take_resume(ActiveRun& run);
  void take_back_permission();  // a person's, to switch servos on: its moment is over
  bool has_lost_reference(bool referenced) const;
  Awaitable<Result<void>> use_permission(ActiveRun& run);
  void ask_to_mend(ActiveRun& run, const Error& why);
  Awaitable<Result<void>> stand_unread();
  // clearance.cc
  Awaitable<Result<void>> clear_to_move(ActiveRun& run);
  Awaitable<Result<void>> announce_motion(ActiveRun& run, const std::string& why);
  // closing.cc
  Awaitable<Result<void>> go_to_zero(ActiveRun& run, std::string why);
  Awaitable<Result<void>> return_to_zero(ActiveRun& run);
  Awaitable<Result<void>> note_closure(ActiveRun& run, std::vector<ChannelValue> values,
                                       Stamp measured, std::int64_t line);
  Awaitable<Result<void>> act_on(ActiveRun& run, ClosureRecord record,
                                 plausibility::Closure closure);
  Awaitable<Result<std::optional<plausibility::Closure>>> close_from_side(ActiveRun& run,
                                                                          std::string side);
  Awaitable<Result<std::vector<ChannelValue>>> visit_zero_and_join(ActiveRun& run,
                                                                   std::string cause,
                                                                   Stamp& measured);
  plausibility::Closure zero_of_datum(const ActiveRun& run) const;
  plausibility::Closure closure_of(const ActiveRun& run, const std::vector<ChannelValue>& values,
                                   CellTime measured) const;

  void publish();
  void use_setup(const ActiveRun& run);

  asio::any_io_executor executor_;
  Workbench& bench_;
  Hooks hooks_;
  TaskGroup& tasks_;
  std::unique_ptr<ActiveRun> run_;
  std::optional<DatumOpening> wanted_datum_;  // to be opened before the next point
  std::optional<RunBefore> before_;
  std::optional<RunProgress> last_progress_;
  bool shutting_down_ = false;
  bool stands_ = false;     // the engine sleeps in a hold
  bool axes_lent_ = false;  // to a movement by hand
  ReadBasis read_basis_;    // of a run that could not be read; empty: it was
  bool may_start_ = true;   // false: power or the daemon was away, and nobody has said it yet
  bool computer_was_away_ = false;
  bool had_datum_ = false;
  // Axes when the run began or a person asked for motion, or seen since; empty: not known.
  std::optional<bool> referenced_;
  bool recalls_reference_ = true;  // from the record, when it begins
  std::int64_t reference_notes_ = 0;
  SwitchOn switch_on_ = SwitchOn::no;  // of the next homing: used up by one that succeeds
  std::string announcement_;
  std::string begins_by_itself_;  // why; empty: a person has asked for the run, or it was told
  std::int64_t counted_accepted_ = 0, counted_given_up_ = 0;  // rows up to the last such pause
  std::int64_t sequence_ = 0;
  bool publishing_ = false;
  RunOutlook outlook_;
  WatchList<RunProgress> watchers_;
};

}  // namespace driftwise::application
