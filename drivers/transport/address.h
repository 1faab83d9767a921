#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include "drivers/transport/options.h"
#include "server/core/result.h"

namespace driftwise::transport {

struct TcpAddress {
  std::string host;  // name or number, without brackets
  std::uint16_t port = 0;
};

struct SerialAddress {
  std::string path;  // "/dev/ttyUSB0"; a pty works
};

using Address = std::variant<TcpAddress, SerialAddress>;

// "127.0.0.1:1394", "scanner.lab:1394", "[::1]:1394", or a path that begins with '/'.
// Errors: invalid_argument, reason BAD_ADDRESS. Port 0 is refused: a driver needs the real one.
Result<Address> parse_address(std::string_view text);

enum class Parity { none, even, odd };

struct SerialSettings {
  int baud = 9600, data_bits = 8, stop_bits = 1;
  Parity parity = Parity::none;
  bool xon_xoff = false;
  bool operator==(const SerialSettings&) const = default;
};

// Options baud, data_bits, parity = none|even|odd, stop_bits, flow = none|xonxoff.
SerialSettings read_serial_settings(OptionReader& options, SerialSettings fallback);

}  // namespace driftwise::transport
