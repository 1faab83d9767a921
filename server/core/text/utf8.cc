#include "server/core/text/utf8.h"

namespace driftwise {
namespace {

unsigned char byte_at(std::string_view text, std::size_t at) {
  return static_cast<unsigned char>(text[at]);
}

bool continues(std::string_view text, std::size_t at) {
  return at < text.size() && (byte_at(text, at) & 0xC0) == 0x80;
}

// How many bytes the character at this place takes; 0: it is none.
std::size_t length_at(std::string_view text, std::size_t at) {
  const unsigned char lead = byte_at(text, at);
  const std::size_t length = lead < 0x80                   ? 1
                             : lead >= 0xC2 && lead < 0xE0 ? 2
                             : (lead & 0xF0) == 0xE0       ? 3
                             : lead >= 0xF0 && lead < 0xF5 ? 4
                                                           : 0;
  for (std::size_t k = 1; k < length; ++k)
    if (!continues(text, at + k)) return 0;
  if (length < 3) return length;
  const unsigned char second = byte_at(text, at + 1);
  const bool overlong = (lead == 0xE0 && second < 0xA0) || (lead == 0xF0 && second < 0x90);
  const bool beyond = (lead == 0xED && second >= 0xA0) || (lead == 0xF4 && second >= 0x90);
  return overlong || beyond ? 0 : length;
}

std::optional<std::size_t> bad_from(std::string_view text, std::size_t at) {
  while (at < text.size()) {
    const std::size_t length = length_at(text, at);
    if (length == 0) return at;
    at += length;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::size_t> first_bad_utf8(std::string_view text) { return bad_from(text, 0); }

std::string with_bad_utf8_replaced(std::string text) {
  for (auto bad = bad_from(text, 0); bad; bad = bad_from(text, *bad + 1)) text[*bad] = '?';
  return text;
}

}  // namespace driftwise
