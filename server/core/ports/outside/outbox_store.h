#pragma once
// What receivers outside the machine were told of alarms. As server/core/ports/store.h: calls
// block, one thread. An alarm's own row is the queue: one that no telling speaks of is still to be
// told, so that a kill loses none.

#include <span>
#include <string>
#include <vector>

#include "server/core/records/notify_records.h"
#include "server/core/result.h"

namespace driftwise {

class OutboxStore {
 public:
  virtual ~OutboxStore() = default;
  // Registers receivers that are new, known since `now`. Alarms: those that hold, or were over
  // after over_after.
  virtual Result<OpenTellings> open(std::span<const std::string> receivers, CellTime now,
                                    CellTime over_after) = 0;
  // In one transaction; each replaces that of the same alarm and receiver.
  virtual Result<void> put(std::span<const TellingRecord> tellings) = 0;
  virtual Result<std::vector<TellingRecord>> tellings(int limit) = 0;  // newest alarm first
};

}  // namespace driftwise
