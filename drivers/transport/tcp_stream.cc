#include "drivers/transport/tcp_stream.h"

#include <boost/asio/buffer.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>

#include "drivers/transport/address_key.h"
#include "drivers/transport/as_tuple.h"

namespace driftwise::transport {
namespace {

// A look-up that is under way cannot be ended, only left behind.
struct Answer {
  explicit Answer(const asio::any_io_executor& executor)
      : ended(executor, asio::steady_timer::time_point::max()) {}
  asio::steady_timer ended;  // cancelled when the answer is there, or when nobody waits for it
  error_code error = asio::error::operation_aborted;
  Endpoints found;
};

class TcpStream final : public ByteStream {
 public:
  TcpStream(asio::any_io_executor executor, TcpAddress address, LookUp look_up)
      : executor_(executor),
        socket_(executor),
        resolver_(executor),
        address_(std::move(address)),
        look_up_(std::move(look_up)) {
    if (!look_up_) look_up_ = [this](const TcpAddress&, Found found) { resolve(std::move(found)); };
  }

  Awaitable<error_code> open() override {
    close();
    is_cancelled_ = false;
    // Numbers need no resolver, which would start a thread of its own.
    error_code error;
    const auto number = asio::ip::make_address(address_.host, error);
    Endpoints all{asio::ip::tcp::endpoint(number, address_.port)};
    if (error) {
      answer_ = std::make_shared<Answer>(executor_);
      look_up_(address_, [answer = answer_](error_code failed, Endpoints found) {
        answer->error = failed;
        answer->found = std::move(found);
        answer->ended.cancel();
      });
      (void)co_await answer_->ended.async_wait(kAsTuple);
      error = answer_->error;
      all = std::move(answer_->found);
    }
    if (!error) error = co_await connect_to(std::move(all));
    if (is_cancelled_) error = asio::error::operation_aborted;
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
    leave_look_up();
    socket_.cancel(ignored);
  }

  void close() override {
    error_code ignored;
    leave_look_up();
    socket_.close(ignored);
  }

 private:
  void resolve(Found found) {
    resolver_.async_resolve(address_.host, std::to_string(address_.port),
                            [found = std::move(found)](error_code error, const auto& results) {
                              Endpoints all;
                              for (const auto& result : results) all.push_back(result.endpoint());
                              found(error, std::move(all));
                            });
  }

  // One after the other. An address at which the time ended comes last the next time.
  Awaitable<error_code> connect_to(Endpoints all) {
    error_code error = asio::error::host_not_found;
    for (std::size_t i = 0; i < all.size() && error && !is_cancelled_; ++i) {
      error_code ignored;
      socket_.close(ignored);
      std::tie(error) = co_await socket_.async_connect(all[first_ % all.size()], kAsTuple);
      if (error) ++first_;
    }
    co_return error;
  }

  void leave_look_up() {
    is_cancelled_ = true;
    resolver_.cancel();
    if (answer_) answer_->ended.cancel();
  }

  asio::any_io_executor executor_;
  asio::ip::tcp::socket socket_;
  asio::ip::tcp::resolver resolver_;
  TcpAddress address_;
  LookUp look_up_;
  std::shared_ptr<Answer> answer_;  // of the last look-up
  bool is_cancelled_ = false;
  std::size_t first_ = 0;  // address to begin with
};

}  // namespace

std::unique_ptr<ByteStream> make_tcp_stream(asio::any_io_executor executor, TcpAddress address,
                                            LookUp look_up) {
  return std::make_unique<TcpStream>(std::move(executor), std::move(address), std::move(look_up));
}

std::unique_ptr<ByteStream> make_tcp_stream(asio::any_io_executor executor, TcpAddress address) {
  return make_tcp_stream(std::move(executor), std::move(address), {});
}

std::unique_ptr<ByteStream> make_stream(asio::any_io_executor executor, const Address& address,
                                        const SerialSettings& settings) {
  if (const auto* serial = std::get_if<SerialAddress>(&address))
    return make_serial_stream(std::move(executor), *serial, settings);
  return make_tcp_stream(std::move(executor), std::get<TcpAddress>(address));
}

}  // namespace driftwise::transport
