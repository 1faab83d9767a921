#include "server/line/line_socket.h"

#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/write.hpp>

namespace driftwise::line {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

class PlainSocket final : public LineSocket {
 public:
  explicit PlainSocket(tcp::socket socket) : socket_(std::move(socket)) {}
  void shake_hands(std::function<void(Code)> done) override { done({}); }
  void read_some(std::span<char> into, Handler done) override {
    socket_.async_read_some(asio::buffer(into.data(), into.size()), std::move(done));
  }
  void write(std::string_view bytes, Handler done) override {
    asio::async_write(socket_, asio::buffer(bytes), std::move(done));
  }
  void close() override {
    Code ignored;
    socket_.close(ignored);
  }
  std::optional<tls::PeerCertificate> certificate() override { return std::nullopt; }

 private:
  tcp::socket socket_;
};

class TlsSocket final : public LineSocket {
 public:
  TlsSocket(tcp::socket socket, std::shared_ptr<asio::ssl::context> context)
      : context_(std::move(context)), stream_(std::move(socket), *context_) {}
  void shake_hands(std::function<void(Code)> done) override {
    stream_.async_handshake(asio::ssl::stream_base::server, std::move(done));
  }
  void read_some(std::span<char> into, Handler done) override {
    stream_.async_read_some(asio::buffer(into.data(), into.size()), std::move(done));
  }
  void write(std::string_view bytes, Handler done) override {
    asio::async_write(stream_, asio::buffer(bytes), std::move(done));
  }
  void close() override {
    Code ignored;
    stream_.next_layer().close(ignored);
  }
  std::optional<tls::PeerCertificate> certificate() override {
    return tls::peer_certificate(stream_.native_handle());
  }

 private:
  std::shared_ptr<asio::ssl::context> context_;
  asio::ssl::stream<tcp::socket> stream_;
};

}  // namespace

std::unique_ptr<LineSocket> LineSocket::make(tcp::socket socket,
                                             std::shared_ptr<asio::ssl::context> tls) {
  if (tls) return std::make_unique<TlsSocket>(std::move(socket), std::move(tls));
  return std::make_unique<PlainSocket>(std::move(socket));
}

}  // namespace driftwise::line
