#pragma once
// Files that came compressed (.gz, RFC 1952): bytes in, bytes out, by zlib.

#include <cstddef>
#include <string>
#include <string_view>

#include "server/core/result.h"

namespace driftwise::formats {

bool is_gzip(std::string_view bytes);  // by its first two bytes

// All members of the file, one after the other. file_name: stands in front of every message.
// Errors, invalid_argument: BAD_GZIP (damaged, or what follows the last member is none),
// TRUNCATED_GZIP, TOO_LARGE (more than most_bytes when inflated: a small file can hold a huge one).
Result<std::string> gunzip(std::string_view bytes, const std::string& file_name,
                           std::size_t most_bytes);

}  // namespace driftwise::formats
