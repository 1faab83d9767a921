#pragma once
// The socket of one client of the text line: plain, or behind TLS. One operation each way at a
// time; handlers run on the executor's thread.

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "server/tls/peer_certificate.h"

namespace driftwise::line {

class LineSocket {
 public:
  using Code = boost::system::error_code;
  using Handler = std::function<void(Code, std::size_t)>;

  // tls: null for a plain one.
  static std::unique_ptr<LineSocket> make(boost::asio::ip::tcp::socket socket,
                                          std::shared_ptr<boost::asio::ssl::context> tls);
  virtual ~LineSocket() = default;

  virtual void shake_hands(std::function<void(Code)> done) = 0;  // of a plain one: at once
  virtual void read_some(std::span<char> into, Handler done) = 0;
  virtual void write(std::string_view bytes, Handler done) = 0;  // bytes live until it is done
  virtual void close() = 0;
  virtual std::optional<tls::PeerCertificate> certificate() = 0;  // after shake_hands
};

}  // namespace driftwise::line
