#pragma once
// Addresses as cell.toml writes them.

#include <string>
#include <string_view>

#include "server/formats/text/toml_reader.h"

namespace driftwise::formats {

struct HostPort {
  std::string_view host, port;
};

// At the last colon; without one the port is empty.
HostPort split_address(std::string_view address);

bool is_port(std::string_view text, int lowest);

bool has_blank(std::string_view host);

// Two TCP addresses that lead to one door: host without case, localhost is 127.0.0.1, and
// 0.0.0.0 is every address on loopback too; port 0 (a free one): never. Two paths of serial lines:
// where they lead here, /dev/serial/by-id/... to /dev/ttyUSB0.
bool is_one_place(std::string_view one, std::string_view other);

// host:port with a number of a port, or the path of a serial line. Refused at key "address",
// BAD_ADDRESS.
void check_device_address(TomlReader& reader, const std::string& address);

}  // namespace driftwise::formats
