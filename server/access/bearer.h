#pragma once
// The token of an "Authorization" header, for every door.

#include <string_view>

namespace driftwise::access {

// "Bearer dwt_..." -> "dwt_...", at most 256 bytes of it: a token is some sixty characters. The
// scheme's case does not matter (RFC 7235, 2.1). Empty: no header, another scheme, or no token.
// The result is a part of header.
std::string_view bearer_in(std::string_view header);

}  // namespace driftwise::access
