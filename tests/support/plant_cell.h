#pragma once
// Devices of a shipped cell in memory: the simulated plant behind the ports, without a wire, on
// virtual time. What each channel says can be altered.

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "drivers/simulated/plant/file/make_plant.h"
#include "server/application/cell/cell.h"
#include "tests/support/virtual_time.h"

namespace driftwise::tests {

// What one channel says instead of the truth. True values are remembered for those that are late.
class Liar {
 public:
  // value: the true one; at: when it was asked for. The result goes to the daemon.
  using Lie = std::function<double(double value, CellTime at)>;

  // through_zero: zeroing the instrument takes nothing of it away.
  void tell(std::string channel, Lie lie, bool through_zero = false) {
    channel_ = std::move(channel);
    through_zero_ = through_zero;
    lie_ = std::move(lie);
    first_.reset();
    last_.reset();
    taken_off_ = 0;
    zeroed_ = false;
  }
  void stop() {
    lie_ = nullptr;
    taken_off_ = 0;
    zeroed_ = false;
  }
  // The instrument made what it says its zero: a jump from before is gone with that.
  void zeroed(const std::string& channel) {
    if (lie_ && channel == channel_ && !through_zero_) zeroed_ = true;
  }

  double say(const std::string& channel, double value, CellTime at);
  // The newest true value of a channel; kMissing before the first.
  double truth(const std::string& channel) const;
  // ... and the one of that instant: the newest not after it, else the oldest known.
  double truth(const std::string& channel, CellTime at) const;

  // The first and the last false answer since tell().
  std::optional<CellTime> first() const { return first_; }
  std::optional<CellTime> last() const { return last_; }

 private:
  struct Said {
    CellTime at;
    double value;
  };
  std::string channel_;
  Lie lie_;
  bool zeroed_ = false, through_zero_ = false;
  double taken_off_ = 0;  // by the zeroing
  std::optional<CellTime> first_, last_;
  std::map<std::string, std::deque<Said>> true_;
};

// A plant and its liar; the devices look at both, and at the time.
struct PlantWorld {
  std::unique_ptr<simulated::CellPlant> plant;
  Liar liar;
};

// cell: "linear-axis" or "micro-nano", as shipped. coarse: one instant per reading, and steps of 2
// s instead of 0.1 s on the Micro-Nano: the same physics and spreads, several times as fast. Throws
// PlantFileError.
PlantWorld make_plant_world(const std::string& cell, CellTime begin, std::uint64_t seed,
                            bool coarse);

// The shipped cell.toml with another database. Throws std::runtime_error.
CellDescription shipped_cell(const std::string& cell, const std::string& database);
std::string shipped_trajectory(const std::string& cell);

application::Devices plant_devices(PlantWorld& world, VirtualTime& time,
                                   const CellDescription& cell);

}  // namespace driftwise::tests
