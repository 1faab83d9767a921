#include "server/formats/text/text_encoding.h"

#include "server/core/reasons.h"

namespace driftwise::formats {
namespace {

void append_utf8(std::string& out, std::uint32_t code) {
  const auto byte = [&](std::uint32_t value) { out += static_cast<char>(value); };
  if (code < 0x80) return byte(code);
  if (code < 0x800) return byte(0xC0 | code >> 6), byte(0x80 | (code & 0x3F));
  if (code < 0x10000)
    return byte(0xE0 | code >> 12), byte(0x80 | (code >> 6 & 0x3F)), byte(0x80 | (code & 0x3F));
  byte(0xF0 | code >> 18), byte(0x80 | (code >> 12 & 0x3F));
  byte(0x80 | (code >> 6 & 0x3F)), byte(0x80 | (code & 0x3F));
}

tl::unexpected<Error> not_text(const std::string& file_name, const std::string& sentence) {
  return fail(ErrorCode::invalid_argument, reasons::kNotText, file_name + ": " + sentence);
}

Result<std::string> from_utf16(std::string_view bytes, bool low_first,
                               const std::string& file_name) {
  if (bytes.size() % 2 != 0)
    return not_text(file_name, "found UTF-16 text of an odd number of bytes, expected two each");
  const auto unit = [&](std::size_t at) {
    const auto first = static_cast<std::uint8_t>(bytes[at]);
    const auto second = static_cast<std::uint8_t>(bytes[at + 1]);
    return static_cast<std::uint32_t>(low_first ? first | second << 8 : first << 8 | second);
  };
  std::string out;
  out.reserve(bytes.size() / 2);
  for (std::size_t at = 0; at < bytes.size(); at += 2) {
    std::uint32_t code = unit(at);
    if (code >= 0xD800 && code < 0xE000) {  // half of a pair
      const std::uint32_t low = at + 3 < bytes.size() ? unit(at + 2) : 0;
      if (code >= 0xDC00 || low < 0xDC00 || low >= 0xE000)
        return not_text(file_name, "found half a UTF-16 surrogate pair at byte " +
                                       std::to_string(at) + ", expected text");
      code = 0x10000 + ((code - 0xD800) << 10) + (low - 0xDC00);
      at += 2;
    }
    append_utf8(out, code);
  }
  return out;
}

}  // namespace

Result<std::string> to_utf8(std::string_view bytes, TextEncoding encoding,
                            const std::string& file_name) {
  const auto mark = [&](std::string_view expected, TextEncoding found) {
    if (!bytes.starts_with(expected)) return;
    bytes.remove_prefix(expected.size());
    encoding = found;
  };
  mark("\xEF\xBB\xBF", TextEncoding::utf_8);
  mark("\xFF\xFE", TextEncoding::utf_16_le);
  mark("\xFE\xFF", TextEncoding::utf_16_be);
  Result<std::string> out = std::string();
  switch (encoding) {
    case TextEncoding::utf_8:
      out->assign(bytes);
      break;
    case TextEncoding::latin_1:
      for (const char c : bytes) append_utf8(*out, static_cast<std::uint8_t>(c));
      break;
    case TextEncoding::utf_16_le:
    case TextEncoding::utf_16_be:
      out = from_utf16(bytes, encoding == TextEncoding::utf_16_le, file_name);
      break;
  }
  if (out)
    if (const auto zero = out->find('\0'); zero != std::string::npos)
      return not_text(file_name, "found a zero byte at byte " + std::to_string(zero) +
                                     ", expected text: is it a table? is it UTF-16 without its "
                                     "mark (encoding = \"utf-16-le\")?");
  return out;
}

}  // namespace driftwise::formats
