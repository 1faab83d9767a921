#pragma once
// Latest instants that a plant solved: several instruments ask for the same ones.

#include <array>
#include <cstddef>

#include "drivers/simulated/plant/plant.h"

namespace driftwise::simulated {

// Instant: a struct with `double time_s` and `TimeNs now`, the plant's clock when it was solved.
template <typename Instant>
class RecentInstants {
 public:
  // The instant of time_s as seen at `now`; solve(Instant&) fills it in where it is not known. It
  // stands until kKept others were solved, or until forget().
  template <typename Solve>
  const Instant& at(double time_s, TimeNs now, const Solve& solve) {
    for (std::size_t i = 0; i < count_; ++i)
      if (kept_[i].time_s == time_s && kept_[i].now == now) return kept_[i];
    Instant& place = kept_[next_];
    next_ = (next_ + 1) % kKept;
    if (count_ < kKept) ++count_;
    place.time_s = time_s;
    place.now = now;
    solve(place);
    return place;
  }

  // Nothing that was solved is true any longer: parameters changed, or a command was given.
  void forget() { count_ = next_ = 0; }

 private:
  static constexpr std::size_t kKept = 32;
  std::array<Instant, kKept> kept_{};
  std::size_t count_ = 0, next_ = 0;
};

}  // namespace driftwise::simulated
