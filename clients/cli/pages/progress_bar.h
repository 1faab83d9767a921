#pragma once
// One line about a run under way: redrawn in place on a terminal, else a line now and then. What a
// run waits for has a line of its own on a terminal, and is on the line elsewhere.

#include <chrono>
#include <string>

#include "clients/cli/core/console.h"
#include "driftwise/v1/cell_service.pb.h"
#include "driftwise/v1/run.pb.h"

namespace driftwise::cli {

// The line's text, at most width characters:
//   run 3 moving [########............]  412/1008  41 %  spread 3.1 nm  ends 12:41:07 (1 h 02 min)
// remaining_s: wall seconds until the estimated end, NaN when unknown. Pure.
std::string progress_line(const v1::RunProgress& progress, double remaining_s, int width);

class ProgressBar {
 public:
  // A run that waits and goes on all the time must not fill a log.
  static constexpr int kStatesAtOnce = 10;
  static constexpr std::chrono::seconds kRefill{30};

  // status: gives cell time and speed, from which the time left on the wall follows.
  ProgressBar(const Console& console, const v1::GetStatusResponse& status);
  ~ProgressBar();  // leaves the line standing and ends it
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void show(const v1::RunProgress& progress);

 private:
  double remaining_s(const v1::RunProgress& progress) const;
  bool may_tell_state(v1::Run::State state);

  const Console& console_;
  v1::GetStatusResponse status_;
  std::chrono::steady_clock::time_point asked_, drawn_{};
  bool open_line_ = false;
  int last_tenth_ = -1;
  v1::Run::State last_state_ = v1::Run::STATE_UNSPECIFIED;
  std::string last_reason_;
  // Changes of state that a log may still be told at once; one more every kRefill.
  int states_left_ = kStatesAtOnce;
  std::chrono::steady_clock::time_point refilled_{};
};

}  // namespace driftwise::cli
