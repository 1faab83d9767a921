#pragma once
// Files of the state folder that hold secrets: only their owner may read them.

#include <optional>
#include <string>
#include <string_view>

#include "server/core/result.h"

namespace driftwise::access {

// In one piece, on disk before it answers, mode 0600. Errors: unavailable CANNOT_WRITE.
Result<void> write_private_file(const std::string& path, std::string_view text);

// Nothing: there is no such file. Errors: failed_precondition FILE_READABLE (group or others may
// read it, with the chmod that ends that); unavailable CANNOT_OPEN.
Result<std::optional<std::string>> read_private_file(const std::string& path);

}  // namespace driftwise::access
