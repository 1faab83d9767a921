#pragma once
// Where a text line listens, and whom it lets in. Reads the computer's network interfaces.

#include <boost/asio/ip/tcp.hpp>
#include <string>
#include <vector>

#include "server/core/result.h"

namespace driftwise::line {

// "127.0.0.1:50052", "localhost:0", "[::1]:0". Errors: invalid_argument BAD_ADDRESS.
Result<boost::asio::ip::tcp::endpoint> endpoint_from(const std::string& address);

std::string text_of(const boost::asio::ip::tcp::endpoint& end);  // as endpoint_from reads it

// The interface has this address, or none of its family yet, as before its cable is in. Errors:
// failed_precondition NOT_ON_INTERFACE, with the addresses that were found; unavailable
// NOT_ON_INTERFACE: the interfaces cannot be read.
Result<void> check_interface(const std::string& interface, const boost::asio::ip::address& address);

// Addresses that may come in: "192.168.7.10", "192.168.7.0/24", "fd00::10".
class AddressList {
 public:
  // Errors: invalid_argument BAD_ADDRESS, naming the entry; MISSING_KEY: an empty list.
  static Result<AddressList> from(const std::vector<std::string>& entries);
  bool holds(const boost::asio::ip::address& address) const;

 private:
  struct Network {
    std::vector<unsigned char> bytes;
    unsigned bits = 0;
  };
  std::vector<Network> networks_;
};

}  // namespace driftwise::line
