#pragma once
// Receivers outside the machine: listed with what they were told, tried out. Executor's thread.

#include <optional>
#include <string>
#include <vector>

#include "server/application/ports/caller.h"
#include "server/core/ports/awaitable.h"
#include "server/core/records/notify_records.h"
#include "server/core/result.h"

namespace driftwise::application {

struct ReceiverStatus {
  std::string name;
  std::string way;           // "webhook https://alerts.example.org"
  std::int64_t waiting = 0;  // alarms that it is still to be told of
  CellTime delivered;        // the last message that arrived; utc_ns 0: none since the start
  CellTime failing_since;    // utc_ns 0: it is well, as far as is known
  std::string answer;        // the last thing that it, or the way to it, said
};

class Notifications {
 public:
  virtual ~Notifications() = default;
  // In the order of the cell file; the watchdog, where there is one, is the last.
  virtual std::vector<ReceiverStatus> receivers() const = 0;
  virtual Awaitable<Result<std::vector<TellingRecord>>> tellings(int limit) = 0;
  // Sends a message that says that it is a test; what the receiver said. Errors: not_found
  // NO_SUCH_RECEIVER; unavailable NOT_DELIVERED.
  virtual Awaitable<Result<std::string>> test(Caller caller, std::string receiver) = 0;
};

}  // namespace driftwise::application
