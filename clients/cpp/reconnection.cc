#include "clients/cpp/reconnection.h"

#include <chrono>

namespace driftwise::client {

Reconnection::~Reconnection() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void Reconnection::lost() {
  {
    const std::lock_guard lock(mutex_);
    lost_ = true;
    if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
  }
  changed_.notify_all();
}

void Reconnection::run() {
  // Longest time that the destructor waits for the thread.
  constexpr std::chrono::milliseconds kSlice(100);
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return lost_ || ending_; });
    if (ending_) return;
    lost_ = false;
    lock.unlock();
    const auto state = channel_->GetState(/*try_to_connect=*/true);
    if (state != GRPC_CHANNEL_READY)
      channel_->WaitForStateChange(state, std::chrono::system_clock::now() + kSlice);
    lock.lock();
    if (state != GRPC_CHANNEL_READY) lost_ = true;
  }
}

}  // namespace driftwise::client
