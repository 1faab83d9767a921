#include "drivers/transport/address_key.h"

#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>

namespace driftwise::transport {

namespace asio = boost::asio;

std::string tcp_key(const std::string& ip, std::uint16_t port) {
  boost::system::error_code error;
  auto address = asio::ip::make_address(ip, error);
  if (!error && address.is_v6() && address.to_v6().is_v4_mapped())
    address = asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6());
  return "tcp:" + (error ? ip : address.to_string()) + ":" + std::to_string(port);
}

std::string serial_key(const std::string& path) {
  struct stat found {};
  if (stat(path.c_str(), &found) != 0 || !S_ISCHR(found.st_mode)) return {};
  return "serial:" + std::to_string(major(found.st_rdev)) + ":" +
         std::to_string(minor(found.st_rdev));
}

std::vector<std::string> keys_of(const Address& address) {
  std::vector<std::string> keys;
  if (const auto* serial = std::get_if<SerialAddress>(&address)) {
    if (auto key = serial_key(serial->path); !key.empty()) keys.push_back(std::move(key));
    return keys;
  }
  const auto& tcp = std::get<TcpAddress>(address);
  boost::system::error_code error;
  if (const auto number = asio::ip::make_address(tcp.host, error); !error)
    return {tcp_key(number.to_string(), tcp.port)};
  asio::io_context io;
  asio::ip::tcp::resolver resolver(io);
  for (const auto& found : resolver.resolve(tcp.host, std::to_string(tcp.port), error))
    keys.push_back(tcp_key(found.endpoint().address().to_string(), tcp.port));
  return keys;
}

}  // namespace driftwise::transport
