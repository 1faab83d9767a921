#pragma once
// A plain client of the text line.

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <string>
#include <string_view>

namespace driftwise::tests {

namespace asio = boost::asio;

// A client that speaks as a controller would: blocking, one line at a time.
class LineClient {
 public:
  explicit LineClient(const std::string& address) : socket_(context_) {
    const auto port = static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1)));
    socket_.connect(asio::ip::tcp::endpoint(asio::ip::address_v4::loopback(), port));
  }
  void send(std::string_view text) { asio::write(socket_, asio::buffer(text)); }
  std::string line() {  // without its end; "" when the server closed
    boost::system::error_code error;
    const auto size = asio::read_until(socket_, asio::dynamic_buffer(text_), '\n', error);
    if (error) return {};
    std::string out = text_.substr(0, size - 1);
    text_.erase(0, size);
    return out;
  }
  std::string ask(const std::string& request) {
    send(request + "\n");
    return line();
  }

 private:
  asio::io_context context_;
  asio::ip::tcp::socket socket_;
  std::string text_;
};

}  // namespace driftwise::tests
