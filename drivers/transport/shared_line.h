#pragma once
// A serial line on which several [[device]] are declared: two coordinates that one read-out serves
// in turn. Each has a connection of its own, but what one of them asks must not be read by another.

#include <boost/asio/any_io_executor.hpp>
#include <cstdint>
#include <memory>
#include <string>

#include "drivers/transport/address.h"
#include "server/core/ports/async_mutex.h"
#include "server/core/ports/control/shared_by_address.h"

namespace driftwise::transport {

struct SharedLine {
  explicit SharedLine(asio::any_io_executor executor) : turn(std::move(executor)) {}

  AsyncMutex turn;                // of one call of one device
  std::int64_t disturbances = 0;  // calls that left an answer under way, or a device in doubt
};

// The address's place in a SharedByAddress: one text for every name of one serial device; of any
// other address its own text.
std::string shared_key(const Address& address, const std::string& text);

// The line at this address. A TCP connection is nobody else's, and so is a line of a device that
// was made alone (shared: nullptr).
std::shared_ptr<SharedLine> line_at(const Address& address, asio::any_io_executor executor,
                                    SharedByAddress* shared);

}  // namespace driftwise::transport
