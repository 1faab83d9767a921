#include "server/application/plumbing/pause_meter.h"

#include <algorithm>

namespace driftwise::application {
namespace {

constexpr auto kPeriod = std::chrono::milliseconds(50);

}  // namespace

void PauseMeter::start() {
  ended_ = false;
  wait();
}

void PauseMeter::shut_down() {
  ended_ = true;
  timer_.cancel();
}

void PauseMeter::wait() {
  timer_.expires_after(kPeriod);
  timer_.async_wait([this](const boost::system::error_code& cancelled) {
    if (cancelled || ended_) return;
    note(timer_.expiry(), std::chrono::steady_clock::now());
    wait();
  });
}

void PauseMeter::note(Instant due, Instant now) {
  const double pause_s = std::max(0.0, std::chrono::duration<double>(now - due).count());
  longest_s_ = std::max(longest_s_, pause_s);
  while (!recent_.empty() && recent_.back().second <= pause_s) recent_.pop_back();
  recent_.emplace_back(now, pause_s);
  while (recent_.front().first + kRecent < now) recent_.pop_front();
}

double PauseMeter::recent_s(Instant now) const {
  for (const auto& [at, pause_s] : recent_)
    if (at + kRecent >= now) return pause_s;
  return 0;
}

}  // namespace driftwise::application
