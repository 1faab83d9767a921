#pragma once
// The lease to move, for as long as this object lives: renewed in time on a thread of its own,
// given up at the end.

#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "clients/cli/core/connection.h"

namespace driftwise::cli {

class HeldLease {
 public:
  // given: a token from `driftwise lease take`: used as it is, neither renewed nor given up. Empty:
  // takes a lease. Throws Failure when somebody else holds it.
  HeldLease(const Connection& connection, std::string given);
  ~HeldLease();
  HeldLease(const HeldLease&) = delete;
  HeldLease& operator=(const HeldLease&) = delete;

  const std::string& token() const { return token_; }
  // To a job of the daemon's that goes on and renews it: it is not given up at the end.
  void leave() { left_ = true; }

 private:
  void renew_until_stopped();

  const Connection& connection_;
  std::string token_;
  double lease_s_ = 60;  // cell seconds asked for
  std::chrono::milliseconds every_{20000};
  std::mutex mutex_;
  std::condition_variable stop_asked_;
  bool stopping_ = false, left_ = false;
  std::optional<std::thread> thread_;
};

}  // namespace driftwise::cli
