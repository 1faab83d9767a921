#include <boost/asio/buffer.hpp>
#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>

#include "drivers/transport/address_key.h"
#include "drivers/transport/as_tuple.h"
#include "drivers/transport/byte_stream.h"

namespace driftwise::transport {
namespace {

class TcpStream final : public ByteStream {
 public:
  TcpStream(asio::any_io_executor executor, TcpAddress address)
      : socket_(executor), resolver_(executor), address_(std::move(address)) {}

  Awaitable<error_code> open() override {
    close();
    // Numbers need no resolver, which would start a thread of its own.
    error_code error;
    const auto number = asio::ip::make_address(address_.host, error);
    if (!error) {
      std::tie(error) = co_await socket_.async_connect({number, address_.port}, kAsTuple);
    } else {
      asio::ip::tcp::resolver::results_type found;
      std::tie(error, found) =
          co_await resolver_.async_resolve(address_.host, std::to_string(address_.port), kAsTuple);
      if (error) co_return error;
      asio::ip::tcp::endpoint used;
      std::tie(error, used) = co_await asio::async_connect(socket_, found, kAsTuple);
    }
    if (!error) socket_.set_option(asio::ip::tcp::no_delay(true), error);
    if (!error) socket_.set_option(asio::socket_base::keep_alive(true), error);
    if (!error) socket_.non_blocking(true, error);
    if (error) close();
    co_return error;
  }

  Awaitable<Transfer> write(std::string_view bytes) override {
    const auto [error, count] = co_await asio::async_write(socket_, asio::buffer(bytes), kAsTuple);
    co_return Transfer{error, count};
  }

  Awaitable<Transfer> read_some(std::span<char> into) override {
    const auto [error, count] =
        co_await socket_.async_read_some(asio::buffer(into.data(), into.size()), kAsTuple);
    co_return Transfer{error, count};
  }

  error_code write_now(std::string_view bytes) override {
    error_code error;
    socket_.write_some(asio::buffer(bytes), error);
    return error;
  }

  Transfer read_now(std::span<char> into) override {
    Transfer out;
    out.bytes = socket_.read_some(asio::buffer(into.data(), into.size()), out.error);
    return out;
  }

  bool is_open() const override { return socket_.is_open(); }

  std::string peer_key() const override {
    error_code error;
    const auto peer = socket_.remote_endpoint(error);
    return error ? std::string() : tcp_key(peer.address().to_string(), peer.port());
  }

  void cancel() override {
    error_code ignored;
    resolver_.cancel();
    socket_.cancel(ignored);
  }

  void close() override {
    error_code ignored;
    resolver_.cancel();
    socket_.close(ignored);
  }

 private:
  asio::ip::tcp::socket socket_;
  asio::ip::tcp::resolver resolver_;
  TcpAddress address_;
};

}  // namespace

std::unique_ptr<ByteStream> make_tcp_stream(asio::any_io_executor executor, TcpAddress address) {
  return std::make_unique<TcpStream>(std::move(executor), std::move(address));
}

std::unique_ptr<ByteStream> make_stream(asio::any_io_executor executor, const Address& address,
                                        const SerialSettings& settings) {
  if (const auto* serial = std::get_if<SerialAddress>(&address))
    return make_serial_stream(std::move(executor), *serial, settings);
  return make_tcp_stream(std::move(executor), std::get<TcpAddress>(address));
}

}  // namespace driftwise::transport
