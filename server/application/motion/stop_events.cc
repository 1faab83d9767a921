#include "server/application/motion/stop_events.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace driftwise::application {

void StopEvents::record(const Caller& caller, std::optional<RunId> run) {
  constexpr std::size_t kMostNames = 5;
  const auto now = clock_.now().utc;
  last_ = now;
  ++presses_;
  hold_ = {RunHold::Kind::stop, caller.name, now, fmt::format("stopped by {}", caller.name)};
  if (bursting_) {
    ++further_;
    ++in_all_;
    if (names_.size() < kMostNames) names_.insert(caller.name);
    return;
  }
  events_.record(caller, "stop", fmt::format("{} stopped everything", caller.name), run);
  run_ = run;
  in_all_ = 1;
  told_ = now;
  bursting_ = true;
  tasks_.spawn(wait_out());
}

void StopEvents::shut_down() {
  ending_ = true;
  ended_.raise();
}

Awaitable<void> StopEvents::wait_out() {
  for (;;) {
    const auto now = clock_.now().utc;
    if (ending_ || now - last_ >= kQuiet) break;
    if (further_ > 0 && now - told_ >= kTold) tell();
    co_await sleep_unless(clock_, std::min(last_ + kQuiet, std::max(now, told_) + kTold), ended_);
  }
  if (further_ > 0) tell();
  bursting_ = false;
}

void StopEvents::tell() {
  events_.record_own("stop.repeated",
                     fmt::format("{} further stops, {} in a row, by {}", further_, in_all_,
                                 fmt::join(names_, ", ")),
                     run_);
  further_ = 0;
  names_.clear();
  told_ = clock_.now().utc;
}

}  // namespace driftwise::application
