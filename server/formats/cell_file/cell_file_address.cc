#include "server/formats/cell_file/cell_file_address.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>

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

bool has_blank(std::string_view host) {
  return host.find_first_of(" \t\r\n\v\f") != std::string_view::npos;
}

bool is_one_place(std::string_view one, std::string_view other) {
  const auto place = [](std::string_view address) {
    const auto [host, port] = split_address(address);
    std::string name(host);
    std::ranges::transform(name, name.begin(), [](unsigned char letter) {
      return static_cast<char>(std::tolower(letter));
    });
    if (name == "localhost") name = "127.0.0.1";
    int number = 0;  // "08080" is 8080; port 0 is a free one, of nobody yet
    std::from_chars(port.data(), port.data() + port.size(), number);
    return std::pair(name, number);
  };
  if (one.starts_with('/') || other.starts_with('/')) {
    std::error_code ignored;  // a path that cannot be followed is compared as it is written
    return one.starts_with('/') && other.starts_with('/') &&
           std::filesystem::weakly_canonical(one, ignored) ==
               std::filesystem::weakly_canonical(other, ignored);
  }
  const auto first = place(one), second = place(other);
  if (first.second == 0 || first.second != second.second) return false;
  const auto is_any = [](const std::string& host) { return host == "0.0.0.0" || host == "[::]"; };
  const auto is_here = [&](const std::string& host) {
    return is_any(host) || host.starts_with("127.") || host == "[::1]";
  };
  return first.first == second.first || (is_any(first.first) && is_here(second.first)) ||
         (is_any(second.first) && is_here(first.first));
}

void check_device_address(TomlReader& reader, const std::string& address) {
  if (address.empty() || address.front() == '/') return;
  const auto [host, port] = split_address(address);
  const bool open_ipv6 =
      host.find(':') != std::string_view::npos && !(host.starts_with('[') && host.ends_with(']'));
  if (host.empty() || has_blank(host) || open_ipv6 || !is_port(port, 1))
    reader.refuse("address", reasons::kBadAddress,
                  "found " + shown(address) +
                      ", expected host:port such as 127.0.0.1:50000 without blanks, with a port "
                      "from 1 to 65535, "
                      "or a serial line such as /dev/ttyUSB0");
}

}  // namespace driftwise::formats
