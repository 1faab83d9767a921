#pragma once
// The real Clock: CLOCK_REALTIME times the speed of the cell. With speed 1 and no file, cell time
// is UTC.
//
// Waits are steady timers on the executor, armed anew whenever the speed changes: at speed 200 a
// cell second is 5 ms of wall time, and the timer is as exact as the kernel's (some 60 us).

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <list>
#include <memory>

#include "server/application/clock_file.h"
#include "server/application/speed_governor.h"
#include "server/core/cell_description.h"
#include "server/core/ports/clock.h"

namespace driftwise::application {

class CellClock : public Clock {
 public:
  // Opens the clock file where the description names one; at speed 1 a file that is not there is
  // done without. Errors: those of ClockFile::open; invalid_argument CLOCK_SPEED (a speed other
  // than 1 without a file).
  static Result<std::unique_ptr<CellClock>> open(asio::any_io_executor executor,
                                                 const ClockDescription& description);
  ~CellClock() override;

  Stamp now() const override;
  double speed() const override;
  Awaitable<void> sleep_until(CellTime instant) override;
  std::chrono::nanoseconds wall_from(Nanoseconds cell,
                                     std::chrono::nanoseconds floor) const override;
  void report_lag(Nanoseconds lag) override;

 private:
  struct Sleeper {
    asio::steady_timer timer;
    bool arm_again = false;
  };
  CellClock(asio::any_io_executor executor, std::unique_ptr<ClockFile> file, ClockAnchor anchor);
  void change_speed(double speed);

  asio::any_io_executor executor_;
  std::unique_ptr<ClockFile> file_;
  SpeedGovernor governor_;
  SharedAnchor anchor_;     // wall clock to cell time ...
  SharedAnchor monotonic_;  // ... and the steady clock to cell nanoseconds since the start
  std::list<Sleeper*> sleepers_;
};

}  // namespace driftwise::application
