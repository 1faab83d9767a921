#pragma once
// The run under way, as values: what the engine's parts share about it.

#include <map>
#include <optional>
#include <vector>

#include "server/application/motion/datum_opening.h"
#include "server/application/motion/run_control.h"
#include "server/application/motion/workbench.h"
#include "server/application/ports/run_plan.h"
#include "server/application/runs/run_progress.h"
#include "server/application/runs/suspects.h"
#include "server/application/runs/trajectory_walk.h"
#include "server/application/trajectories/motor_rows.h"
#include "server/application/trajectories/outlook.h"
#include "server/core/trajectory/trajectory.h"
#include "server/formats/cell_file/cell_file_closure.h"
#include "server/plausibility/closure_judge.h"

namespace driftwise::application {

struct ActiveRun {
  ActiveRun(const asio::any_io_executor& executor, Workbench& bench, RunRecord r, RunPlan p,
            Trajectory t)
      : record(std::move(r)),
        plan(std::move(p)),
        trajectory(std::move(t)),
        control(executor),
        scope{bench, control, plan.rules, record.id, {}, {}, {}},
        length(trajectory),
        meter(planned_visit_s(plan.rules)),
        closure_rules(formats::closure_rules_of(bench.description)),
        closure_judge(bench.description, closure_rules) {
    scope.moved = axes_moved_by(bench.description, trajectory.coordinates);
  }
  ActiveRun(const ActiveRun&) = delete;

  RunRecord record;
  RunPlan plan;
  Trajectory trajectory;
  RunControl control;
  RunScope scope;
  PlanLength length;
  StepMeter meter;
  bool continued = false;  // was under way when the daemon ended
  // Plan and trajectory could not be read. Its record in the store stays as the last daemon left
  // it, but for what a person wants: the next start decides by it.
  bool unread = false;
  std::optional<DatumRecord> datum;  // the present one
  Closures closures;                 // of the present datum
  ClosureRules closure_rules;
  plausibility::ClosureJudge closure_judge;
  SinceClosure since_closure;
  SinceReturn since_return;
  std::map<std::int64_t, int> repetitions;  // of lines, by number
  std::vector<double> jumped_nm;            // of each length, by jumps that only marked their line
  std::map<std::int64_t, int> attempts_of_row;
  RunProgress progress;
  bool state_unstored = false;         // the disk was full: the record has another state
  std::vector<double> last_stored_mm;  // of the newest row or passage on disk, as read back
};

}  // namespace driftwise::application
