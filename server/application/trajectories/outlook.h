#pragma once
// Time that a run will still take, as a band from this cell's own history. One estimator for the
// check of a trajectory, the run under way and the queue. Pure; the same question has the same
// answer.
//
// Two things spread. A whole run is quicker or slower than others: its mean step is a mixture of
// those of the runs before it and of its own so far, each by its weight. Within a run, waits and
// rereads come in bunches: the steps ahead are drawn from the record in blocks, not one by one.

#include <cstdint>
#include <deque>
#include <vector>

#include "server/application/trajectories/run_steps.h"

namespace driftwise::application {

// Cell seconds; the band is the shortest that holds kShare of the draws. Where most runs meet no
// wait it begins at their duration: one with as many draws below it as above would hold more.
struct Outlook {
  static constexpr double kShare = 0.8;
  double expected_s = 0, low_s = 0, high_s = 0;  // expected: the median
  std::int64_t runs = 0, rows = 0;               // that it rests on; runs 0: no history
  std::vector<double> draws_s;
};
// Median and band of draws_s.
void take_figures(Outlook& outlook);

struct RunAhead {
  PlanAhead plan;
  double unit_s = 1;                 // planned_visit_s
  bool leads = true;                 // start checks, homing and the datum are ahead
  double spent_s = 0;                // since the last decision, or since the start
  const RunSteps* so_far = nullptr;  // of this run
  std::uint64_t seed = 1;
};

class DurationHistory {
 public:
  static constexpr std::size_t kMostRuns = 20;

  // The newest last. A run of less than kLeastSteps says nothing.
  void add(RunSteps run);
  void add_all(const DurationHistory& newer);
  bool empty() const { return runs_.empty(); }
  // Duration of a step in this cell, in planned visits; 1 without history.
  double level() const;

 private:
  static constexpr std::size_t kLeastSteps = 5;
  friend Outlook look_ahead(const DurationHistory& history, const RunAhead& ahead);
  struct Series {
    RunSteps steps;
    double visits = 0, level = 0;  // in all; mean of a visit
    std::vector<double> sums;      // of what each step took beyond its level, up to here
  };
  static Series series_of(RunSteps steps);
  std::deque<Series> runs_;
};

// From the last decision of the run, less what was spent since.
Outlook look_ahead(const DurationHistory& history, const RunAhead& ahead);

}  // namespace driftwise::application
