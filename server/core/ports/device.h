#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/core/data/reading.h"
#include "server/core/description/cell_description.h"
#include "server/core/ports/awaitable.h"
#include "server/core/result.h"

namespace driftwise {

enum class LinkState { disconnected, connecting, connected, failed };

struct DeviceHealth {
  LinkState link = LinkState::disconnected;
  std::string identity;  // what the device says it is
  std::int64_t exchanges = 0, errors = 0, reconnects = 0;
  double last_latency_s = 0;  // wall seconds of the last exchange
  std::string last_error;     // empty: none since connecting
  CellTime last_good;         // utc_ns 0: never
  // A device that stamps its answers by a clock of its own: that clock minus cell time, as
  // measured; none: it has no such clock, or nothing was measured yet.
  std::optional<Nanoseconds> clock_offset = {};
  double max_clock_offset_s = 60;  // to UTC: beyond it an alarm
  std::int64_t clock_jumps = 0;    // how often that clock was set, and by how much the last time
  Nanoseconds last_clock_jump{0};
};

// What every device behind a port can do. All calls on the executor's thread; at most one call that
// talks to the device is under way at a time (the caller queues; MotionController::stop is the
// exception). A call reconnects by itself, with back-off; it fails with unavailable while the
// device is away, deadline_exceeded after a time-out, data_loss for bytes that make no sense,
// failed_precondition for the device's own refusal. Messages name device, address, what was sent
// and what came back.
class Device {
 public:
  virtual ~Device() = default;
  virtual const DeviceDescription& description() const = 0;
  virtual DeviceHealth health() const = 0;
  // The last few exchanges as text, oldest first: what was on the wire, for people.
  virtual std::vector<std::string> recent_exchanges() const { return {}; }
  // Connects, identifies and sets the device up; does nothing when that has been done.
  virtual Awaitable<Result<void>> prepare() = 0;
  virtual void close() = 0;
};

}  // namespace driftwise
