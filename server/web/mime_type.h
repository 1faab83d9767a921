#pragma once
#include <string_view>

namespace driftwise::web {

// By the ending of a file's name; application/octet-stream for others, so that no browser guesses.
std::string_view mime_type(std::string_view file_name);

}  // namespace driftwise::web
