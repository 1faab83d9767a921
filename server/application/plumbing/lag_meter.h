#pragma once
// How late does the owner of the cell run? Every wait of the engine and the recorder goes through
// here.

#include <algorithm>

#include "server/application/plumbing/signal.h"
#include "server/core/ports/clock.h"

namespace driftwise::application {

// lag: how much later than asked a wait ended, in cell time. The run keeps its largest; the clock
// gives way to it.
class LagMeter {
 public:
  explicit LagMeter(Clock& clock) : clock_(clock) {}

  Awaitable<void> sleep_unless(CellTime instant, Signal& signal) {
    co_await application::sleep_unless(clock_, instant, signal);
    note(instant);
  }
  // A schedule that was due at this instant is served now.
  void note(CellTime due) {
    const auto lag = clock_.now().utc - due;
    if (lag.count() < 0) return;  // woken early by the signal
    largest_ = std::max(largest_, lag);
    clock_.report_lag(lag);
  }
  double largest_s() const { return seconds_from(largest_); }
  void start_again() { largest_ = Nanoseconds::zero(); }

 private:
  Clock& clock_;
  Nanoseconds largest_{0};
};

}  // namespace driftwise::application
