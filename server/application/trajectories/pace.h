#pragma once
// How long does a plan take? One estimate for its check before and for the run: the visits still
// ahead, returns to zero included, times what a visit takes, and the dwells that the rows state.

#include <cstdint>
#include <deque>
#include <vector>

#include "server/core/cell_time.h"
#include "server/core/description/cell_description.h"
#include "server/core/records/records.h"
#include "server/core/trajectory/trajectory.h"

namespace driftwise::application {

// What a point takes before any was measured: settle, readings and a typical move. Cell seconds.
double guessed_point_s(const RunRules& rules);

// What of a trajectory is still ahead at a place.
class PlanLength {
 public:
  explicit PlanLength(const Trajectory& trajectory);
  // point_s: of one visit, without the dwell its row states.
  double seconds(const Place& place, double point_s) const;

 private:
  std::vector<double> dwell_s_;        // of this row and all after it; one more at the end
  std::vector<std::int64_t> returns_;  // to zero, by itself at the end of a line: likewise
  std::vector<double> own_dwell_s_;    // of this row
};

class Pace {
 public:
  explicit Pace(double guess_s) : guess_s_(guess_s) {}
  void add(double point_s);  // the whole visit, with its repeated attempts, without its dwell
  double point_s() const;    // mean of the last kWindow visits; the guess before the first

 private:
  static constexpr std::size_t kWindow = 60;  // about three lines of the published plan
  double guess_s_;
  double sum_s_ = 0;
  std::deque<double> last_s_;
};

}  // namespace driftwise::application
