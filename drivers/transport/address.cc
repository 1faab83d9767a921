#include "drivers/transport/address.h"

#include <charconv>

#include "server/core/reasons.h"

namespace driftwise::transport {
namespace {

tl::unexpected<Error> bad_address(std::string_view text) {
  return fail(ErrorCode::invalid_argument, reasons::kBadAddress,
              "'" + std::string(text) +
                  "' is no address: expected host:port, [ipv6]:port or /dev/... for a serial port");
}

}  // namespace

Result<Address> parse_address(std::string_view text) {
  if (text.starts_with('/')) return Address(SerialAddress{std::string(text)});
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos || colon == 0) return bad_address(text);
  std::string_view host = text.substr(0, colon);
  if (host.starts_with('[')) {
    if (!host.ends_with(']') || host.size() < 3) return bad_address(text);
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    return bad_address(text);
  }
  const std::string_view digits = text.substr(colon + 1);
  std::uint16_t port = 0;
  const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), port);
  if (code != std::errc{} || end != digits.data() + digits.size() || port == 0)
    return bad_address(text);
  return Address(TcpAddress{std::string(host), port});
}

SerialSettings read_serial_settings(OptionReader& options, SerialSettings fallback) {
  SerialSettings out;
  out.baud = options.integer("baud", fallback.baud, 50, 4'000'000);
  out.data_bits = options.integer("data_bits", fallback.data_bits, 7, 8);
  out.stop_bits = options.integer("stop_bits", fallback.stop_bits, 1, 2);
  const char* parity = fallback.parity == Parity::none   ? "none"
                       : fallback.parity == Parity::even ? "even"
                                                         : "odd";
  const std::string word = options.choice("parity", parity, {"none", "even", "odd"});
  out.parity = word == "none" ? Parity::none : word == "even" ? Parity::even : Parity::odd;
  out.xon_xoff = options.choice("flow", fallback.xon_xoff ? "xonxoff" : "none",
                                {"none", "xonxoff"}) == "xonxoff";
  return out;
}

}  // namespace driftwise::transport
