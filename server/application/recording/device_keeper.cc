#include "server/application/recording/device_keeper.h"

#include <algorithm>

#include "server/application/plumbing/task_group.h"

namespace driftwise::application {

DeviceKeeper::DeviceKeeper(asio::any_io_executor executor, Clock& clock, DeviceBench& bench,
                           TaskGroup& tasks, std::function<bool()> busy)
    : executor_(executor),
      clock_(clock),
      bench_(bench),
      tasks_(tasks),
      busy_(std::move(busy)),
      ended_(executor),
      looked_(executor) {}

void DeviceKeeper::start() {
  untried_ = bench_.size();
  for (std::size_t device = 0; device < bench_.size(); ++device) {
    tasks_.spawn(keep(device));
  }
}

void DeviceKeeper::shut_down() {
  ending_ = true;
  ended_.raise();
  looked_.raise();
}

Awaitable<void> DeviceKeeper::looked() {
  while (untried_ > 0 && !ending_) co_await looked_.wait();
}

Awaitable<void> DeviceKeeper::keep(std::size_t device) {
  constexpr double kPresent_s = 5, kFirst_s = 2, kLongest_s = 60;
  constexpr double kLeastWall_s = 1;  // however fast the cell's clock goes
  double away_s = kFirst_s;
  for (bool first = true; !ending_; first = false) {
    double pause_s = kPresent_s;
    if (first || !busy_()) {
      if (co_await bench_.prepare(device)) {
        away_s = kFirst_s;
      } else {
        pause_s = away_s;
        away_s = std::min(kLongest_s, 2 * away_s);
      }
    }
    if (first && --untried_ == 0) looked_.raise();
    if (ending_) break;
    pause_s = std::max(pause_s, kLeastWall_s * clock_.speed());
    co_await sleep_unless(clock_, clock_.now().utc + nanoseconds_from_s(pause_s), ended_);
  }
}

}  // namespace driftwise::application
