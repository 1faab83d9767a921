#pragma once
// The real Clock: CLOCK_BOOTTIME times the speed of the cell. Setting the computer's wall clock
// changes nothing here. With speed 1 and no file, cell time begins as UTC.
//
// Waits are steady timers on the executor, armed anew whenever the speed changes: at speed 200 a
// cell second is 5 ms of real time, and the timer is as exact as the kernel's (some 60 us). Those
// timers stand still while the computer is suspended: none is armed for longer than a second, so
// that a wait notices the time that has passed.

#include <atomic>
#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <list>
#include <memory>

#include "server/application/upkeep/clock_file.h"
#include "server/application/upkeep/computer_clock.h"
#include "server/application/upkeep/speed_governor.h"
#include "server/core/description/cell_description.h"
#include "server/core/ports/clock.h"

namespace driftwise::application {

class CellClock : public Clock {
 public:
  // Opens the clock file where the description names one; at speed 1 a file that is not there is
  // done without. Errors: those of ClockFile::open; invalid_argument CLOCK_SPEED (a speed other
  // than 1 without a file).
  static Result<std::unique_ptr<CellClock>> open(asio::any_io_executor executor,
                                                 const ClockDescription& description,
                                                 ComputerClock computer = this_computer());
  ~CellClock() override;

  Stamp now() const override;
  double speed() const override;
  Awaitable<void> sleep_until(CellTime instant) override;
  std::chrono::nanoseconds wall_from(Nanoseconds cell,
                                     std::chrono::nanoseconds floor) const override;
  void report_lag(Nanoseconds lag) override;
  SinceBoot since_boot() const override { return {computer_.boot, computer_.boot_ns()}; }
  std::int64_t wall_ahead_ns() const override { return application::wall_ahead_ns(computer_); }
  bool is_simulated() const override { return file_ != nullptr; }
  void begin_at(CellTime now, CellTime not_before) override;

 private:
  struct Sleeper {
    asio::steady_timer timer;
    bool arm_again = false;
  };
  CellClock(asio::any_io_executor executor, std::unique_ptr<ClockFile> file, ClockAnchor anchor,
            ComputerClock computer);
  void change_speed(double speed);

  asio::any_io_executor executor_;
  ComputerClock computer_;
  std::unique_ptr<ClockFile> file_;
  SpeedGovernor governor_;
  SharedAnchor anchor_;                 // time since the computer's start to cell time
  std::atomic<std::int64_t> began_ns_;  // cell time at this clock's begin
  std::list<Sleeper*> sleepers_;
};

}  // namespace driftwise::application
