#include "drivers/transport/escape.h"

namespace driftwise::transport {

std::string escaped(std::string_view bytes, std::size_t max_bytes) {
  constexpr char kHex[] = "0123456789abcdef";
  std::string out;
  for (const char byte : bytes.substr(0, max_bytes)) {
    const auto code = static_cast<unsigned char>(byte);
    switch (byte) {
      case '\r':
        out += "\\r";
        break;
      case '\n':
        out += "\\n";
        break;
      case '\\':
        out += "\\\\";
        break;
      case '"':
        out += "\\\"";
        break;
      default:
        if (code >= 0x20 && code < 0x7f) {
          out += byte;
        } else {
          out += "\\x";
          out += kHex[code >> 4];
          out += kHex[code & 0xf];
        }
    }
  }
  if (bytes.size() > max_bytes)
    out += "...(+" + std::to_string(bytes.size() - max_bytes) + " bytes)";
  return out;
}

}  // namespace driftwise::transport
