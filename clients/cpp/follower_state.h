#pragma once
// The thread behind a TargetFollower: reads the stream, and opens it again when it ends.

#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>

#include "clients/cpp/include/driftwise/client.h"
#include "clients/cpp/link.h"

namespace driftwise::client {

struct TargetFollower::State {
  State(std::shared_ptr<Link> to, Pose pose, std::chrono::milliseconds min_interval);
  ~State();
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  Answer<Target> latest() const;
  std::uint64_t sequence() const;
  std::uint64_t wait(std::uint64_t seen, std::chrono::milliseconds limit) const;

 private:
  void run();
  bool read_one_stream();  // true: it asks for another one at once
  void publish(Answer<Target> news);

  const std::shared_ptr<Link> link_;
  const Pose pose_;
  std::chrono::milliseconds min_interval_;  // of the thread

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  Answer<Target> latest_;                          // under mutex_, as all below
  std::chrono::steady_clock::time_point expires_;  // of a target, by this computer's clock
  std::uint64_t sequence_ = 0;
  bool ending_ = false;
  grpc::ClientContext* open_ = nullptr;  // the stream being read, for the destructor to cancel

  std::thread thread_;
};

}  // namespace driftwise::client
