#include "server/application/runs/run_outlook.h"

#include <algorithm>

namespace driftwise::application {
namespace {

Outlook spent_since(Outlook outlook, double since_s) {
  for (double& s : outlook.draws_s) s = std::max(0.0, s - since_s);
  for (double* s : {&outlook.expected_s, &outlook.low_s, &outlook.high_s})
    *s = std::max(0.0, *s - since_s);
  return outlook;
}

}  // namespace

// Worked out when a row was decided, or when what is under way takes longer than a visit.
Outlook RunOutlook::of(const ActiveRun& run, CellTime now, const LookAhead& look_ahead) {
  const double spent_s = run.meter.spent_s(now), unit_s = run.meter.unit_s();
  const auto steps = run.meter.steps().took.size(), requeued = run.record.place.requeued.size();
  const double since_s = done_since_s(run, now);
  // Anew after a twentieth of the steps so far, and as soon as those since have taken a visit
  // longer than planned.
  double longer = 0;
  for (std::size_t i = steps_; i < steps; ++i)
    longer += run.meter.steps().took[i] - run.meter.steps().visits[i];
  const bool same = !made_.draws_s.empty() && steps >= steps_ && steps <= steps_ + steps / 20 &&
                    longer < 1 && requeued_ == requeued && since_s >= 0 &&
                    spent_s < (steps == steps_ ? spent_s_ : 0) + unit_s;
  if (!same) {
    RunAhead ahead;
    ahead.plan = run.length.ahead(run.record.place);
    ahead.unit_s = unit_s;
    ahead.leads = run.meter.leads();
    ahead.spent_s = spent_s;
    ahead.so_far = &run.meter.steps();
    made_ = look_ahead(ahead);
    spent_s_ = spent_s;
    steps_ = steps;
    requeued_ = requeued;
  }
  auto outlook = spent_since(made_, done_since_s(run, now));
  outlook.draws_s.clear();
  return outlook;
}

std::optional<Outlook> RunOutlook::kept(const ActiveRun& run, CellTime now) const {
  if (made_.draws_s.empty()) return std::nullopt;
  return spent_since(made_, std::max(0.0, done_since_s(run, now)));
}

// Of what the outlook had ahead: the steps since at what was planned for them, and the one under
// way. A wait is no progress.
double RunOutlook::done_since_s(const ActiveRun& run, CellTime now) const {
  const auto& steps = run.meter.steps();
  const double unit_s = run.meter.unit_s();
  double visits = 0;
  for (std::size_t i = steps_; i < steps.took.size(); ++i)
    visits += std::min(steps.took[i], steps.visits[i]);
  const double of_this_s = run.meter.spent_s(now) - (steps.took.size() == steps_ ? spent_s_ : 0);
  return visits * unit_s + std::min(of_this_s, unit_s);
}

}  // namespace driftwise::application
