#pragma once
// What systemd wants to hear (Type=notify), with no library: READY=1 when made, WATCHDOG=1 twice
// per period from the executor (so a hung executor is noticed), STOPPING=1 when destroyed; STATUS=
// while the start waits. Without NOTIFY_SOCKET it does nothing. Source: sd_notify(3).

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <memory>
#include <string>

namespace driftwise {

// Why the start takes its time, for `systemctl status`; one line.
void tell_service_manager_of_wait(const std::string& why);

class ServiceManager {
 public:
  explicit ServiceManager(boost::asio::any_io_executor executor);
  ~ServiceManager();
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;

 private:
  struct Watchdog;
  std::string socket_;
  std::shared_ptr<Watchdog> watchdog_;
};

}  // namespace driftwise
