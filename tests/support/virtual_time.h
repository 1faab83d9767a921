#pragma once
// Time that passes only when nobody has anything left to do: hours of a campaign in milliseconds,
// always in the same order. The test's loop polls the executor until it is idle, then moves the
// time to the next sleeper.

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <map>

#include "server/core/ports/clock.h"

namespace driftwise::tests {

class VirtualTime {
 public:
  explicit VirtualTime(CellTime begin) : begin_(begin), now_(begin) {}

  Stamp now() const { return {now_, (now_ - begin_).count()}; }
  Awaitable<void> sleep_until(CellTime instant) {
    if (instant <= now_) co_return;
    asio::steady_timer timer(co_await asio::this_coro::executor,
                             asio::steady_timer::time_point::max());
    const auto place = sleepers_.emplace(instant, &timer);
    struct Leave {
      std::multimap<CellTime, asio::steady_timer*>& from;
      std::multimap<CellTime, asio::steady_timer*>::iterator place;
      ~Leave() { from.erase(place); }
    } leave{sleepers_, place};
    co_await timer.async_wait(asio::as_tuple(asio::use_awaitable));
  }
  // Wakes whoever sleeps shortest. False: nobody sleeps.
  bool step() {
    if (sleepers_.empty()) return false;
    now_ = std::max(now_, sleepers_.begin()->first);
    for (auto s = sleepers_.begin(); s != sleepers_.end() && s->first <= now_; ++s)
      s->second->cancel();
    return true;
  }
  Nanoseconds largest_lag{0};
  Nanoseconds wall_clock_set{0};  // how far somebody has set the wall clock, in all

 private:
  CellTime begin_, now_;
  std::multimap<CellTime, asio::steady_timer*> sleepers_;
};

// What a cell owns: it looks at the test's time.
class VirtualClock final : public Clock {
 public:
  explicit VirtualClock(VirtualTime& time) : time_(time) {}
  Stamp now() const override { return time_.now(); }
  double speed() const override { return 1; }
  Awaitable<void> sleep_until(CellTime instant) override { return time_.sleep_until(instant); }
  std::chrono::nanoseconds wall_from(Nanoseconds cell,
                                     std::chrono::nanoseconds floor) const override {
    return std::max<std::chrono::nanoseconds>(cell, floor);
  }
  SinceBoot since_boot() const override { return {"virtual", time_.now().utc.utc_ns}; }
  std::int64_t wall_ahead_ns() const override { return time_.wall_clock_set.count(); }
  void report_lag(Nanoseconds lag) override {
    time_.largest_lag = std::max(time_.largest_lag, lag);
  }

 private:
  VirtualTime& time_;
};

}  // namespace driftwise::tests
