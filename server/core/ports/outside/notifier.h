#pragma once
// The way out of the machine. Calls block for at most kLongest; any thread, several at a time.

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "server/core/description/notify_description.h"
#include "server/core/records/notify_records.h"
#include "server/core/result.h"

namespace driftwise {

// What a receiver took. A mail goes to each of its recipients by itself: the others have it.
struct Delivery {
  struct Refused {
    std::string address, why;  // "bob@lab.example", "450 4.2.0 greylisted"
    bool for_now = false;      // a 4xx: tried again later it may be taken
  };
  Delivery() = default;
  Delivery(std::string what) : said(std::move(what)) {}  // implicit: mostly it is all there is
  std::string said;
  std::vector<Refused> refused;  // recipients
};

class Notifier {
 public:
  static constexpr std::chrono::seconds kLongest{30};

  virtual ~Notifier() = default;
  // What the receiver said ("HTTP 200", "250 2.0.0 Ok: queued"). Errors: unavailable NOT_DELIVERED
  // with what was said instead, also where all recipients are refused; failed_precondition
  // NOT_DELIVERED where they are refused for good, BAD_SECRET_FILE; cancelled SHUTTING_DOWN.
  virtual Result<Delivery> tell(const ReceiverDescription& receiver, const Notice& notice) = 0;
  // A sign of life to a watchdog. Errors: as above.
  virtual Result<std::string> report(const WatchdogRules& watchdog, const LifeSign& sign) = 0;
  // Calls under way end within a second.
  virtual void shut_down() = 0;
};

}  // namespace driftwise
