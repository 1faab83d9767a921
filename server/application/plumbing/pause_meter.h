#pragma once
// Pauses of the executor: how long it ran one handler, or nothing at all, while others waited. A
// timer that is due every 50 ms is late by the pause. Executor's thread.

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <deque>
#include <utility>

#include "server/core/ports/awaitable.h"

namespace driftwise::application {

class PauseMeter {
 public:
  using Instant = std::chrono::steady_clock::time_point;
  // From here on a pause is an alarm: twenty times what a stop may take to be passed on.
  static constexpr double kAlarm_s = 1.0;
  static constexpr std::chrono::seconds kRecent{60};

  explicit PauseMeter(const asio::any_io_executor& executor) : timer_(executor) {}

  void start();
  void shut_down();

  double longest_s() const { return longest_s_; }  // since start()
  double recent_s(Instant now) const;              // of the last kRecent
  double recent_s() const { return recent_s(std::chrono::steady_clock::now()); }

  // A timer that was due then fires now.
  void note(Instant due, Instant now);

 private:
  void wait();

  asio::steady_timer timer_;
  std::deque<std::pair<Instant, double>> recent_;  // falling lengths: the first is the longest
  double longest_s_ = 0;
  bool ended_ = true;
};

}  // namespace driftwise::application
