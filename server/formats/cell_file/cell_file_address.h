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

// host:port with a number of a port, or the path of a serial line. Refused at key "address",
// BAD_ADDRESS.
void check_device_address(TomlReader& reader, const std::string& address);

}  // namespace driftwise::formats
