#pragma once
// Text files in the encodings that measuring programs write -> UTF-8.

#include <cstdint>
#include <string>
#include <string_view>

#include "server/core/result.h"

namespace driftwise::formats {

enum class TextEncoding : std::uint8_t { utf_8, latin_1, utf_16_le, utf_16_be };

// A byte order mark (UTF-8, UTF-16) is taken off and wins over what was said. UTF-8 stays as it is,
// wrong bytes included: what is a number is checked where it is read.
// Errors, invalid_argument NOT_TEXT: UTF-16 of an odd number of bytes or with half a surrogate
// pair; a zero byte in anything.
Result<std::string> to_utf8(std::string_view bytes, TextEncoding encoding,
                            const std::string& file_name);

}  // namespace driftwise::formats
