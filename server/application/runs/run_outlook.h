#pragma once
// Outlook of the run under way: when it ends, as a band. Its draws cost more than a row's own work:
// they are made anew now and then, and the time that was spent is taken off in between.

#include <functional>
#include <optional>

#include "server/application/runs/active_run.h"
#include "server/application/trajectories/outlook.h"

namespace driftwise::application {

class RunOutlook {
 public:
  using LookAhead = std::function<Outlook(const RunAhead&)>;

  // Another run.
  void begin_anew() { *this = {}; }
  // Without draws.
  Outlook of(const ActiveRun& run, CellTime now, const LookAhead& look_ahead);
  // As made last, with its draws; none: there is none yet.
  std::optional<Outlook> kept(const ActiveRun& run, CellTime now) const;

 private:
  double done_since_s(const ActiveRun& run, CellTime now) const;

  Outlook made_;  // as of the last decision of a row
  double spent_s_ = 0;
  std::size_t steps_ = 0, requeued_ = 0;
};

}  // namespace driftwise::application
