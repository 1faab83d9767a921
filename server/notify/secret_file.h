#pragma once

#include <string>

#include "server/core/result.h"

namespace driftwise::notify {

// First line of a file that only its owner may read: a token or a password. Errors:
// failed_precondition BAD_SECRET_FILE (missing, empty, longer than 4096 bytes, no regular file,
// readable by others).
Result<std::string> read_secret(const std::string& path);

}  // namespace driftwise::notify
