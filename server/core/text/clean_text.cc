#include "server/core/text/clean_text.h"

#include <cstdint>

#include "server/core/text/utf8.h"

namespace driftwise {
namespace {

struct Character {
  std::uint32_t code = 0;
  std::size_t bytes = 1;
};

// The character at this place of valid UTF-8.
Character character_at(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[at + i]); };
  const std::uint32_t lead = byte(0);
  const std::size_t bytes = lead < 0x80 ? 1 : lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : 4;
  std::uint32_t code = bytes == 1 ? lead : lead & (0x7Fu >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) code = code << 6 | (byte(i) & 0x3Fu);
  return {code, bytes};
}

bool ends_line(std::uint32_t code) {
  return code == '\n' || code == '\r' || code == 0x85 || code == 0x2028 || code == 0x2029;
}

bool is_obeyed(std::uint32_t code) {
  return code < 0x20 || (code >= 0x7F && code < 0xA0) || code == 0x061C || code == 0x200E ||
         code == 0x200F || code == 0x2028 || code == 0x2029 || (code >= 0x202A && code <= 0x202E) ||
         (code >= 0x2066 && code <= 0x2069) || (code >= 0xFFF9 && code <= 0xFFFB);
}

// The usual text, which is left as it is.
bool is_plain(std::string_view text, bool one_line) {
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x7F || (byte < 0x20 && (one_line || (c != '\n' && c != '\t')))) return false;
  }
  return true;
}

std::string cleaned(std::string_view text, bool one_line) {
  if (is_plain(text, one_line)) return std::string(text);
  const std::string valid = with_bad_utf8_replaced(std::string(text));
  std::string out;
  out.reserve(valid.size());
  for (std::size_t at = 0; at < valid.size();) {
    const auto [code, bytes] = character_at(valid, at);
    const bool kept_end = code == '\n' || code == '\t' ||
                          (code == '\r' && at + 1 < valid.size() && valid[at + 1] == '\n');
    if (!is_obeyed(code) || (!one_line && kept_end))
      out.append(valid, at, bytes);
    else
      out += one_line && (code == '\t' || ends_line(code)) ? ' ' : '?';
    at += bytes;
  }
  return out;
}

}  // namespace

std::string clean_line(std::string_view text) { return cleaned(text, true); }
std::string clean_text(std::string_view text) { return cleaned(text, false); }

}  // namespace driftwise
