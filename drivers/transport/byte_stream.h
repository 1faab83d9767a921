#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/system/error_code.hpp>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "drivers/transport/address.h"
#include "server/core/ports/awaitable.h"

namespace driftwise::transport {

using boost::system::error_code;

// Bytes to and from one device. One reader and one writer at a time, on the executor's thread;
// nothing throws. cancel() ends the operation under way with operation_aborted; after close()
// open() starts anew.
class ByteStream {
 public:
  struct Transfer {
    error_code error;
    std::size_t bytes = 0;
  };
  virtual ~ByteStream() = default;
  virtual Awaitable<error_code> open() = 0;
  virtual Awaitable<Transfer> write(std::string_view bytes) = 0;  // all of them
  virtual Awaitable<Transfer> read_some(std::span<char> into) = 0;
  // Without waiting: for a stop that must not queue, and to look at what lies there unread
  // (would_block: nothing).
  virtual error_code write_now(std::string_view bytes) = 0;
  virtual Transfer read_now(std::span<char> into) = 0;
  virtual bool is_open() const = 0;
  // What the other end is known by while the stream is open: address_key.h.
  virtual std::string peer_key() const { return {}; }
  virtual void cancel() = 0;
  virtual void close() = 0;
};

// TCP with TCP_NODELAY: requests are small and wait for nobody.
std::unique_ptr<ByteStream> make_tcp_stream(asio::any_io_executor executor, TcpAddress address);
// A serial port in raw mode; opening it drops what was left in its queues. A character that arrives
// with a framing or parity error is NUL.
std::unique_ptr<ByteStream> make_serial_stream(asio::any_io_executor executor,
                                               SerialAddress address, SerialSettings settings);
std::unique_ptr<ByteStream> make_stream(asio::any_io_executor executor, const Address& address,
                                        const SerialSettings& settings);

}  // namespace driftwise::transport
