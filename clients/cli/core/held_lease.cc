#include "clients/cli/core/held_lease.h"

#include <algorithm>
#include <chrono>

#include "driftwise/v1/cell_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

v1::TakeLeaseRequest lease_request(double cell_seconds, const std::string& token) {
  v1::TakeLeaseRequest request;
  request.mutable_lease_duration()->set_seconds(static_cast<std::int64_t>(cell_seconds));
  request.set_token(token);
  return request;
}

}  // namespace

HeldLease::HeldLease(const Connection& connection, std::string given)
    : connection_(connection), token_(std::move(given)) {
  if (!token_.empty()) return;
  const auto status = connection_.ask(&v1::CellService::Stub::GetStatus, v1::GetStatusRequest{});
  // A minute on the wall; a fast simulated cell counts in its own time, and no lease is longer than
  // its hour.
  const double speed = std::max(status.speed(), 1e-3);
  lease_s_ = std::clamp(60.0 * speed, 1.0, 3600.0);
  every_ = std::chrono::milliseconds(
      std::max<std::int64_t>(100, static_cast<std::int64_t>(lease_s_ / speed * 1e3 / 3)));
  token_ = connection_.ask(&v1::CellService::Stub::TakeLease, lease_request(lease_s_, ""))
               .lease()
               .token();
  thread_.emplace([this] { renew_until_stopped(); });
}

HeldLease::~HeldLease() {
  if (!thread_) return;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  stop_asked_.notify_all();
  thread_->join();
  if (left_) return;
  try {
    v1::GiveUpLeaseRequest request;
    request.set_token(token_);
    connection_.uninterrupted().ask(&v1::CellService::Stub::GiveUpLease, request, 2.0);
  } catch (const Failure&) {  // it runs out by itself
  }
}

void HeldLease::renew_until_stopped() {
  std::unique_lock lock(mutex_);
  while (!stop_asked_.wait_for(lock, every_, [this] { return stopping_; })) {
    lock.unlock();
    try {
      connection_.ask(&v1::CellService::Stub::TakeLease, lease_request(lease_s_, token_), 5.0);
    } catch (const Failure&) {  // the next call that needs it says what is wrong
    }
    lock.lock();
  }
}

}  // namespace driftwise::cli
