#pragma once
// What an emulated device will do later, in order of time. Events due at the same instant run in
// the order in which they were asked for, so that one seed and one sequence of requests give one
// sequence of replies. Memory: events that are done or cancelled are gone. One thread.

#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "drivers/simulated/plant/plant.h"

namespace driftwise::simulated {

constexpr TimeNs kSecondNs = 1'000'000'000;
// Held within 100 years, so that an instant and a duration add up within 64 bits; NaN is 0.
constexpr TimeNs nanoseconds_from(double seconds) {
  constexpr double kLongestS = 100 * 365.25 * 86'400;
  if (!(seconds > -kLongestS)) seconds = seconds < 0 ? -kLongestS : 0;
  if (seconds > kLongestS) seconds = kLongestS;
  return static_cast<TimeNs>(seconds * 1e9 + (seconds < 0 ? -0.5 : 0.5));
}
constexpr double seconds_between(TimeNs from, TimeNs to) {
  return static_cast<double>(to - from) * 1e-9;
}

class Timeline {
 public:
  using Action = std::function<void(TimeNs)>;  // called with the instant at which it was due
  using EventId = std::pair<TimeNs, std::uint64_t>;

  EventId at(TimeNs due, Action action);
  void cancel(const EventId& event) { events_.erase(event); }  // nothing when it has run already
  std::optional<TimeNs> next() const;
  // Runs the earliest event; its action may add others. Nothing when there is none.
  void run_next();

 private:
  std::uint64_t last_ = 0;
  std::map<EventId, Action> events_;
};

}  // namespace driftwise::simulated
