#pragma once
// RFC 4648 section 4, for what travels as text over HTTP: grpc-web-text bodies, "-bin" headers.

#include <optional>
#include <string>
#include <string_view>

namespace driftwise::web {

std::string base64_encode(std::string_view bytes, bool padded = true);

// Takes padded and unpadded text, also several padded pieces one after the other (a body that was
// sent in pieces). Nothing for anything else.
std::optional<std::string> base64_decode(std::string_view text);

}  // namespace driftwise::web
