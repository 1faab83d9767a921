#include "server/formats/cell_file/cell_file_address.h"

#include <charconv>

#include "server/core/reasons.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {

HostPort split_address(std::string_view address) {
  const auto colon = address.rfind(':');
  if (colon == std::string_view::npos) return {address, {}};
  return {address.substr(0, colon), address.substr(colon + 1)};
}

bool is_port(std::string_view text, int lowest) {
  int port = -1;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), port);
  return code == std::errc{} && end == text.data() + text.size() && port >= lowest && port <= 65535;
}

void check_device_address(TomlReader& reader, const std::string& address) {
  if (address.empty() || address.front() == '/') return;
  const auto [host, port] = split_address(address);
  const bool open_ipv6 =
      host.find(':') != std::string_view::npos && !(host.starts_with('[') && host.ends_with(']'));
  if (host.empty() || open_ipv6 || !is_port(port, 1))
    reader.refuse("address", reasons::kBadAddress,
                  "found " + shown(address) +
                      ", expected host:port such as 127.0.0.1:50000 with a port from 1 to 65535, "
                      "or a serial line such as /dev/ttyUSB0");
}

}  // namespace driftwise::formats
