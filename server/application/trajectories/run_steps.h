#pragma once
// A run as a row of durations: what each row of its plan took, with its rereads, its visits once
// more, and the waits, returns to zero and new datums before it. Pure.

#include <vector>

#include "server/application/trajectories/plan_length.h"
#include "server/core/cell_time.h"
#include "server/core/records/records.h"

namespace driftwise::application {

struct RunSteps {
  std::vector<double> took;    // without the dwell that the row states, in planned visits
  std::vector<double> visits;  // that the plan has in each
  double lead_s = kMissing;    // from the start to the first visit
  double tail_s = kMissing;    // from the last decision to the end
};

class StepMeter {
 public:
  explicit StepMeter(double unit_s = 1) : unit_s_(unit_s) {}

  void begin(CellTime at);         // of the run, or of the daemon that continues it
  void visit_begins(CellTime at);  // the first one ends the lead
  // again: a row that was queued again; its time belongs to the step before.
  void visited(bool again, PlanAhead row, CellTime at);
  void end(CellTime at);
  // A person keeps the run, or the daemon is away: that time counts nothing.
  void keep(CellTime at);
  void let_go(CellTime at);

  // Since the last decision, or since begin() before the first visit.
  double spent_s(CellTime now) const;
  bool leads() const { return leads_; }
  double unit_s() const { return unit_s_; }
  const RunSteps& steps() const { return steps_; }

 private:
  double unit_s_;
  CellTime last_{}, kept_since_{};
  double kept_s_ = 0;
  bool leads_ = true, keeping_ = false;
  RunSteps steps_;
};

// Of a run on record. kept: instants at which a person or a restart let it continue; the gap
// between two attempts that has one in it counts nothing.
StepMeter meter_of(const RunRecord& run, const std::vector<AttemptRecord>& attempts,
                   const PlanLength& plan, double unit_s, const std::vector<CellTime>& kept);

}  // namespace driftwise::application
