#pragma once
// Clocks for tests. WallClock: real time, with a speed. ManualClock: time moves only when the test
// moves it, or jumps to the end of every sleep.

#include <algorithm>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>
#include <memory>
#include <vector>

#include "server/core/ports/clock.h"

namespace driftwise::tests {

inline constexpr CellTime kTestEpoch{1'795'248'000'000'000'000};  // 2026-11-21T08:00:00Z

class WallClock final : public Clock {
 public:
  explicit WallClock(double speed = 1.0, CellTime epoch = kTestEpoch)
      : speed_(speed), epoch_(epoch) {}

  Stamp now() const override {
    const std::chrono::nanoseconds wall = std::chrono::steady_clock::now() - started_;
    const auto cell = static_cast<std::int64_t>(static_cast<double>(wall.count()) * speed_);
    return {epoch_ + Nanoseconds(cell), cell};
  }
  double speed() const override { return speed_; }
  Awaitable<void> sleep_until(CellTime instant) override {
    asio::steady_timer timer(co_await asio::this_coro::executor);
    timer.expires_after(wall_from(instant - now().utc, std::chrono::nanoseconds(0)));
    (void)co_await timer.async_wait(asio::as_tuple(asio::use_awaitable));
  }
  std::chrono::nanoseconds wall_from(Nanoseconds cell,
                                     std::chrono::nanoseconds floor) const override {
    const auto wall = static_cast<std::int64_t>(static_cast<double>(cell.count()) / speed_);
    return std::max(std::chrono::nanoseconds(wall), floor);
  }
  void report_lag(Nanoseconds) override {}
  void run_at(double speed) { speed_ = speed; }  // before anybody looks

 private:
  double speed_;
  CellTime epoch_;
  std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
};

class ManualClock final : public Clock {
 public:
  enum class Sleeps { wait_for_the_test, jump };
  explicit ManualClock(Sleeps sleeps = Sleeps::jump, CellTime epoch = kTestEpoch)
      : sleeps_(sleeps), epoch_(epoch), now_(epoch) {}

  Stamp now() const override { return {now_, (now_ - epoch_).count()}; }
  double speed() const override { return 1.0; }
  Awaitable<void> sleep_until(CellTime instant) override {
    if (sleeps_ == Sleeps::jump) {
      now_ = std::max(now_, instant);
      // Others get their turn, as in a real sleep.
      co_await asio::post(co_await asio::this_coro::executor, asio::use_awaitable);
      co_return;
    }
    if (instant <= now_) co_return;
    auto timer = std::make_shared<asio::steady_timer>(co_await asio::this_coro::executor,
                                                      asio::steady_timer::time_point::max());
    sleepers_.push_back({instant, timer});
    (void)co_await timer->async_wait(asio::as_tuple(asio::use_awaitable));
  }
  std::chrono::nanoseconds wall_from(Nanoseconds cell,
                                     std::chrono::nanoseconds floor) const override {
    return std::max<std::chrono::nanoseconds>(cell, floor);
  }
  void report_lag(Nanoseconds lag) override { largest_lag_ = std::max(largest_lag_, lag); }

  void advance(Nanoseconds by) {
    now_ = now_ + by;
    std::erase_if(sleepers_, [this](const auto& sleeper) {
      if (sleeper.until > now_) return false;
      sleeper.timer->cancel();
      return true;
    });
  }
  std::size_t sleeping() const { return sleepers_.size(); }
  Nanoseconds largest_lag() const { return largest_lag_; }

 private:
  struct Sleeper {
    CellTime until;
    std::shared_ptr<asio::steady_timer> timer;
  };
  Sleeps sleeps_;
  CellTime epoch_, now_;
  Nanoseconds largest_lag_{0};
  std::vector<Sleeper> sleepers_;
};

}  // namespace driftwise::tests
