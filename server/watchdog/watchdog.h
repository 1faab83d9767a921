#pragma once
// The watchdog as a whole: keeps every head, raises the alarm when a cell falls silent, says when
// it is back. A message that does not arrive is tried again until it does; one that stands is
// repeated.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/core/description/notify_description.h"
#include "server/core/ports/outside/notifier.h"
#include "server/core/result.h"
#include "server/tls/tls_material.h"

namespace driftwise::watchdog {

struct WatchdogOptions {
  std::string listen = "127.0.0.1:9470";
  std::string token;
  std::unique_ptr<tls::TlsMaterial> tls;
  std::string heads;                // path of the file
  std::vector<std::string> expect;  // cells that must speak from the start
  double silent_after_s = 120;
  ReceiverDescription receiver;
};

// Runs until over() says so, which is asked five times a second. ready: called with the address at
// which it listens. say: a line for the log.
Result<void> run_watchdog(WatchdogOptions options, Notifier& notifier,
                          const std::function<void(const std::string& address)>& ready,
                          const std::function<void(const std::string& line)>& say,
                          const std::function<bool()>& over);

}  // namespace driftwise::watchdog
