#pragma once
// Connects the cell's devices from the start and again while they are away, so that what status
// shows is so before a run needs it. A device that answers costs nothing: prepare() then only sees
// that the line still stands. While a run or a movement by hand is under way it keeps out of the
// way: they wait for their devices themselves.

#include <functional>

#include "server/application/plumbing/task_group.h"
#include "server/application/recording/device_bench.h"
#include "server/core/ports/clock.h"

namespace driftwise::application {

class DeviceKeeper {
 public:
  // busy: true while something else moves or measures.
  DeviceKeeper(asio::any_io_executor executor, Clock& clock, DeviceBench& bench, TaskGroup& tasks,
               std::function<bool()> busy);

  void start();
  void shut_down();
  Awaitable<void> looked();  // resumes when every device has been tried once

 private:
  Awaitable<void> keep(std::size_t device);

  asio::any_io_executor executor_;
  Clock& clock_;
  DeviceBench& bench_;
  TaskGroup& tasks_;
  std::function<bool()> busy_;
  std::size_t untried_ = 0;
  bool ending_ = false;
  Signal ended_, looked_;
};

}  // namespace driftwise::application
