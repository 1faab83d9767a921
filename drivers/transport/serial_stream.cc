#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/serial_port.hpp>
#include <boost/asio/write.hpp>
#include <cerrno>

#include "drivers/transport/address_key.h"
#include "drivers/transport/as_tuple.h"
#include "drivers/transport/byte_stream.h"

namespace driftwise::transport {
namespace {

using asio::serial_port_base;

error_code last_error() { return {errno, boost::system::system_category()}; }

class SerialStream final : public ByteStream {
 public:
  SerialStream(asio::any_io_executor executor, SerialAddress address, SerialSettings settings)
      : port_(std::move(executor)), address_(std::move(address)), settings_(settings) {}

  Awaitable<error_code> open() override {
    close();
    error_code error;
    port_.open(address_.path, error);  // raw, 8 bits, receiver on
    apply(error);
    if (!error) error = mark_damaged_bytes();
    if (!error && ::tcflush(port_.native_handle(), TCIOFLUSH) != 0) error = last_error();
    if (error) close();
    co_return error;
  }

  Awaitable<Transfer> write(std::string_view bytes) override {
    const auto [error, count] = co_await asio::async_write(port_, asio::buffer(bytes), kAsTuple);
    co_return Transfer{error, count};
  }

  Awaitable<Transfer> read_some(std::span<char> into) override {
    const auto [error, count] =
        co_await port_.async_read_some(asio::buffer(into.data(), into.size()), kAsTuple);
    co_return Transfer{error, count};
  }

  // On the bare descriptor: it does not block once Asio has used it, and neither call may.
  error_code write_now(std::string_view bytes) override {
    no_wait();
    const auto count = ::write(port_.native_handle(), bytes.data(), bytes.size());
    return count == static_cast<ssize_t>(bytes.size()) ? error_code{} : last_error();
  }

  Transfer read_now(std::span<char> into) override {
    no_wait();
    const auto count = ::read(port_.native_handle(), into.data(), into.size());
    if (count > 0) return {{}, static_cast<std::size_t>(count)};
    // A quiet line answers 0 (VMIN 0) or EAGAIN; a pty whose other side is gone answers EIO.
    if (count == 0 || errno == EAGAIN) return {asio::error::would_block, 0};
    return {last_error(), 0};
  }

  bool is_open() const override { return port_.is_open(); }

  std::string peer_key() const override { return serial_key(address_.path); }

  void cancel() override {
    error_code ignored;
    port_.cancel(ignored);
  }

  // The kernel waits in close() until the other side has taken what was written: with XON/XOFF for
  // up to 30 s (closing_wait). What was not sent is dropped instead.
  void close() override {
    if (port_.is_open()) ::tcflush(port_.native_handle(), TCOFLUSH);
    error_code ignored;
    port_.close(ignored);
  }

 private:
  void no_wait() {
    ::fcntl(port_.native_handle(), F_SETFL, ::fcntl(port_.native_handle(), F_GETFL) | O_NONBLOCK);
  }

  void apply(error_code& error) {
    const auto set = [&](auto option) {
      if (!error) port_.set_option(option, error);
    };
    set(serial_port_base::baud_rate(static_cast<unsigned>(settings_.baud)));
    set(serial_port_base::character_size(static_cast<unsigned>(settings_.data_bits)));
    set(serial_port_base::stop_bits(settings_.stop_bits == 2 ? serial_port_base::stop_bits::two
                                                             : serial_port_base::stop_bits::one));
    set(serial_port_base::parity(settings_.parity == Parity::none ? serial_port_base::parity::none
                                 : settings_.parity == Parity::even
                                     ? serial_port_base::parity::even
                                     : serial_port_base::parity::odd));
    set(serial_port_base::flow_control(settings_.xon_xoff ? serial_port_base::flow_control::software
                                                          : serial_port_base::flow_control::none));
  }

  // A character with a framing or parity error, as NUL, which every codec refuses. Asio sets IGNPAR
  // for parity none, and the character is then dropped: "1TP-1596.3" arrives as "1TP-196.3".
  error_code mark_damaged_bytes() {
    termios line{};
    if (::tcgetattr(port_.native_handle(), &line) != 0) return last_error();
    line.c_iflag &= ~static_cast<tcflag_t>(IGNPAR | PARMRK);
    line.c_iflag |= INPCK;
    return ::tcsetattr(port_.native_handle(), TCSANOW, &line) == 0 ? error_code{} : last_error();
  }

  asio::serial_port port_;
  SerialAddress address_;
  SerialSettings settings_;
};

}  // namespace

std::unique_ptr<ByteStream> make_serial_stream(asio::any_io_executor executor,
                                               SerialAddress address, SerialSettings settings) {
  return std::make_unique<SerialStream>(std::move(executor), std::move(address), settings);
}

}  // namespace driftwise::transport
