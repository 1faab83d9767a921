#pragma once
// A line at whose address several [[device]] are declared: two coordinates that one read-out serves
// in turn, on a serial port or behind a serial server (host:port). Each has a connection of its
// own, but what one of them asks must not be read by another: a serial server may give every
// connection whatever the line says.

#include <boost/asio/any_io_executor.hpp>
#include <chrono>
#include <cstdint>
#include <map>
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
  // Whose turn was the last one, and its end.
  const void* last_user = nullptr;
  std::chrono::steady_clock::time_point last_end;
};

// The address's place in a SharedByAddress: one text for every name of one serial device; of any
// other address its own text.
std::string shared_key(const Address& address, const std::string& text);

// The lines of the devices that are made together, by key. Outlives their making: two names of one
// port that is not plugged in yet, or two names of one host, are known as one only when the line is
// opened.
class SharedLines {
 public:
  explicit SharedLines(asio::any_io_executor executor) : executor_(std::move(executor)) {}
  std::shared_ptr<SharedLine> at(const std::string& key);

 private:
  asio::any_io_executor executor_;
  std::map<std::string, std::weak_ptr<SharedLine>> lines_;
};

// A device that was made alone (shared: nullptr) has its line for itself.
std::shared_ptr<SharedLines> lines_of(asio::any_io_executor executor, SharedByAddress* shared);

// Line of a device as it is known at this address, before and after it is opened.
class LineKey {
 public:
  LineKey(Address address, std::string text)
      : address_(std::move(address)), text_(std::move(text)) {}
  // peer_key: what the other end is known by (address_key.h); empty: not connected.
  const std::string& now(std::string peer_key);

 private:
  Address address_;
  std::string text_;  // of a TCP address, until it has been connected to
  std::string key_;
};

}  // namespace driftwise::transport
