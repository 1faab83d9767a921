#include "server/application/notify/refused_recipients.h"

#include <algorithm>

namespace driftwise::application {

void RefusedRecipients::take(const Notice& notice, const std::vector<std::string>& to,
                             const std::vector<Delivery::Refused>& refused, CellTime now) {
  for (const auto& address : to) {
    const auto no = std::ranges::find(refused, address, &Delivery::Refused::address);
    const auto known = refused_.find(address);
    if (no == refused.end()) {
      reached_.insert(address);
      if (known == refused_.end()) continue;
      if (known->second.waiting.empty())
        refused_.erase(known);
      else
        known->second.next_try = now;  // the way is open: what waits goes now
      continue;
    }
    Recipient& one = refused_[address];
    if (known == refused_.end()) {
      one.since = now;
      one.next_try = now + nanoseconds_from_s(one.retry_s);
    }
    one.why = no->why;
    one.for_now = no->for_now;
    if (!one.for_now) {
      one.waiting.clear();
      continue;
    }
    one.waiting.push_back(notice);
    if (one.waiting.size() > kMostWaiting) one.waiting.pop_front();
  }
}

std::optional<RefusedRecipients::Due> RefusedRecipients::due(CellTime now) const {
  for (const auto& [address, one] : refused_)
    if (!one.waiting.empty() && one.next_try <= now) return Due{address, one.waiting.front()};
  return std::nullopt;
}

void RefusedRecipients::tried_again(const std::string& address, const Result<Delivery>& said,
                                    CellTime now, double least_wait_s) {
  const auto found = refused_.find(address);
  if (found == refused_.end()) return;
  Recipient& one = found->second;
  if (said) {
    reached_.insert(address);
    if (!one.waiting.empty()) one.waiting.pop_front();
    one.retry_s = kFirstRetry_s;
    one.next_try = now;
    if (one.waiting.empty()) refused_.erase(found);
    return;
  }
  one.why = said.error().message;
  one.for_now = said.error().code != ErrorCode::failed_precondition;
  if (!one.for_now) one.waiting.clear();
  one.retry_s = std::min(2 * one.retry_s, kLongestRetry_s);
  one.next_try = now + nanoseconds_from_s(std::max(one.retry_s, least_wait_s));
}

std::vector<RefusedRecipients::Failing> RefusedRecipients::failing(CellTime now,
                                                                   double patience_s) const {
  std::vector<Failing> out;
  for (const auto& [address, one] : refused_)
    if (!one.for_now || seconds_from(now - one.since) >= patience_s)
      out.push_back({address, one.why, one.since, one.for_now});
  return out;
}

}  // namespace driftwise::application
