#pragma once
// The way out of the machine. Calls block for at most kLongest; any thread, several at a time.

#include <chrono>
#include <string>

#include "server/core/description/notify_description.h"
#include "server/core/records/notify_records.h"
#include "server/core/result.h"

namespace driftwise {

class Notifier {
 public:
  static constexpr std::chrono::seconds kLongest{30};

  virtual ~Notifier() = default;
  // What the receiver said ("HTTP 200", "250 2.0.0 Ok: queued"). Errors: unavailable NOT_DELIVERED
  // with what was said instead; failed_precondition BAD_SECRET_FILE; cancelled SHUTTING_DOWN.
  virtual Result<std::string> tell(const ReceiverDescription& receiver, const Notice& notice) = 0;
  // A sign of life to a watchdog. Errors: as above.
  virtual Result<std::string> report(const WatchdogRules& watchdog, const LifeSign& sign) = 0;
  // Calls under way end within a second.
  virtual void shut_down() = 0;
};

}  // namespace driftwise
