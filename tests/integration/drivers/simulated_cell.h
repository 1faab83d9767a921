#pragma once
// driftwise-cellsim as a process, and its devices as the drivers see them.

#include <gmock/gmock.h>

#include <map>
#include <string>
#include <vector>

#include "server/core/description/cell_description.h"
#include "server/core/ports/clock.h"
#include "tests/support/process.h"
#include "tests/support/run_awaitable.h"

namespace driftwise::tests {

// Cell time as the simulated cell keeps it: read once from the clock file it shares (speed does not
// change here).
class SharedClock final : public Clock {
 public:
  explicit SharedClock(const std::string& clock_file);
  Stamp now() const override;
  double speed() const override { return speed_; }
  Awaitable<void> sleep_until(CellTime instant) override;
  std::chrono::nanoseconds wall_from(Nanoseconds cell,
                                     std::chrono::nanoseconds floor) const override;
  void report_lag(Nanoseconds) override {}

 private:
  std::int64_t anchor_boot_ns_ = 0, anchor_cell_ns_ = 0;
  double speed_ = 1;
};

class SimulatedCell {
 public:
  // settings: "emulator.pi.ini=false", ... Throws std::runtime_error when it does not start.
  // cell: folder under deploy/cells.
  explicit SimulatedCell(const std::vector<std::string>& settings = {}, double speed = 200,
                         const std::string& cell = "linear-axis");
  ~SimulatedCell();
  static bool available();

  DeviceDescription device(const std::string& id) const;
  std::string address(const std::string& name) const { return addresses_.at(name); }
  const std::map<std::string, std::string>& addresses() const { return addresses_; }
  Clock& clock() { return *clock_; }

 private:
  TemporaryFolder folder_;
  std::unique_ptr<Process> process_;
  std::map<std::string, std::string> addresses_;
  CellDescription description_;
  std::unique_ptr<SharedClock> clock_;
};

}  // namespace driftwise::tests
