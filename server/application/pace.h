#pragma once
// When will the run end? From the time that its last points took.

#include <cstdint>
#include <deque>

#include "server/core/cell_description.h"
#include "server/core/cell_time.h"

namespace driftwise::application {

// What a point takes before any was measured: settle, readings and a typical move. Cell seconds.
double guessed_point_s(const RunRules& rules);

class Pace {
 public:
  explicit Pace(double guess_s) : guess_s_(guess_s) {}
  void add(double point_s);  // the whole visit, with its repeated attempts
  double point_s() const;    // mean of the last kWindow visits; the guess before the first
  CellTime estimated_end(CellTime now, std::int64_t visits_left) const;

 private:
  static constexpr std::size_t kWindow = 60;  // about three lines of the published plan
  double guess_s_;
  double sum_s_ = 0;
  std::deque<double> last_s_;
};

}  // namespace driftwise::application
