#include "server/application/trajectories/run_steps.h"

#include <algorithm>
#include <set>

namespace driftwise::application {

void StepMeter::begin(CellTime at) {
  last_ = at;
  kept_s_ = 0;
  leads_ = true;
  keeping_ = false;
}

void StepMeter::keep(CellTime at) {
  if (keeping_) return;
  keeping_ = true;
  kept_since_ = at;
}

void StepMeter::let_go(CellTime at) {
  if (!keeping_) return;
  keeping_ = false;
  kept_s_ += std::max(0.0, seconds_from(at - kept_since_));
}

double StepMeter::spent_s(CellTime now) const {
  const auto until = keeping_ ? kept_since_ : now;
  return std::max(0.0, seconds_from(until - last_) - kept_s_);
}

void StepMeter::visit_begins(CellTime at) {
  if (!leads_) return;
  const double lead_s = spent_s(at);
  leads_ = false;
  if (steps_.took.empty() && is_missing(steps_.lead_s)) steps_.lead_s = lead_s;
  last_ = at;
  kept_s_ = 0;
}

void StepMeter::visited(bool again, PlanAhead row, CellTime at) {
  const double took = std::max(0.0, spent_s(at) - row.dwell_s) / unit_s_;
  last_ = at;
  kept_s_ = 0;
  if (again && !steps_.took.empty()) {
    steps_.took.back() += took;
    return;
  }
  steps_.took.push_back(took);
  steps_.visits.push_back(row.visits);
}

void StepMeter::end(CellTime at) {
  if (!steps_.took.empty()) steps_.tail_s = spent_s(at);
}

StepMeter meter_of(const RunRecord& run, const std::vector<AttemptRecord>& attempts,
                   const PlanLength& plan, double unit_s, const std::vector<CellTime>& kept) {
  StepMeter meter(unit_s);
  meter.begin(run.started);
  std::set<std::int64_t> decided;
  CellTime before = run.started;
  const auto count_gap = [&](CellTime until) {
    const auto found = std::ranges::lower_bound(kept, before);
    if (found == kept.end() || *found > until) return;
    meter.keep(before);
    meter.let_go(until);
  };
  for (const auto& attempt : attempts) {
    count_gap(attempt.started.utc);
    meter.visit_begins(attempt.started.utc);
    before = attempt.ended.utc;
    if (attempt.verdict == Verdict::accepted || attempt.verdict == Verdict::requeued ||
        attempt.verdict == Verdict::given_up)
      meter.visited(!decided.insert(attempt.row).second, plan.row(attempt.row), before);
  }
  if (run.state == RunState::done) {
    count_gap(run.ended);
    meter.end(run.ended);
  }
  return meter;
}

}  // namespace driftwise::application
