#include "server/web/body_budget.h"

#include <utility>

namespace driftwise::web {

BodyBudget::Share::Share(BodyBudget& budget, std::string peer, std::function<void()> close)
    : budget_(budget),
      peer_(std::move(peer)),
      close_(std::move(close)),
      place_(budget.shares_.insert(budget.shares_.end(), this)) {}

BodyBudget::Share::~Share() {
  budget_.bytes_ -= bytes_;
  budget_.shares_.erase(place_);
}

bool BodyBudget::Share::grow_to(std::size_t bytes, DoorInstant now) {
  last_byte_ = now;
  const std::size_t counted = bytes > kFree ? bytes : 0;
  if (counted <= bytes_) return true;
  const std::size_t more = counted - bytes_;
  while (!budget_.fits(*this, more))
    if (!budget_.close_slowest(*this, now)) return false;
  bytes_ += more;
  budget_.bytes_ += more;
  return true;
}

bool BodyBudget::fits(const Share& asking, std::size_t more) const {
  std::size_t of_peer = more;
  for (const auto* share : shares_)
    if (share->peer_ == asking.peer_) of_peer += share->bytes_;
  return of_peer <= limits_.per_peer && bytes_ + more <= limits_.in_all;
}

// Its bytes count as free at once: its connection ends before anything else is read.
bool BodyBudget::close_slowest(const Share& asking, DoorInstant now) {
  Share* slowest = nullptr;
  for (auto* share : shares_) {
    const bool stalled = !share->complete_ && now - share->last_byte_ >= limits_.stalled;
    if (share == &asking || share->bytes_ == 0 || !stalled) continue;
    if (!slowest || share->last_byte_ < slowest->last_byte_) slowest = share;
  }
  if (!slowest) return false;
  bytes_ -= std::exchange(slowest->bytes_, 0);
  slowest->complete_ = true;
  slowest->close_();
  return true;
}

}  // namespace driftwise::web
