#pragma once
// Way back to a daemon that was lost. gRPC moves an attempt to connect forward only while a call
// waits for it. Calls that fail at once wait for nothing; then TCP and TLS take a step every 5 s,
// and a daemon that was away for 2 s is found again after 10 to 20 s. A thread waits in their
// place.

#include <grpcpp/channel.h>

#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>

namespace driftwise::client {

class Reconnection {
 public:
  explicit Reconnection(std::shared_ptr<grpc::Channel> channel) : channel_(std::move(channel)) {}
  ~Reconnection();
  Reconnection(const Reconnection&) = delete;
  Reconnection& operator=(const Reconnection&) = delete;

  // A call found no daemon. The first one starts the thread; it sleeps while there is a connection.
  void lost();

 private:
  void run();

  const std::shared_ptr<grpc::Channel> channel_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool lost_ = false, ending_ = false;  // under mutex_
  std::thread thread_;
};

}  // namespace driftwise::client
