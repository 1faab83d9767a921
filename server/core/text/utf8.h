#pragma once
// Text that is UTF-8, and text that is not. Any thread.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace driftwise {

// Where the first byte stands (from 0) that is no part of valid UTF-8 (RFC 3629: no overlong forms,
// no surrogates, nothing beyond U+10FFFF); nothing when all of it is valid.
std::optional<std::size_t> first_bad_utf8(std::string_view text);

// The text with every such byte as '?'.
std::string with_bad_utf8_replaced(std::string text);

}  // namespace driftwise
