#pragma once
// Presence of a file at a path. A folder that cannot be searched is an error, not an absent file.

#include <string>

namespace driftwise::storage {

// Throws StorageFailure not_found CANNOT_OPEN where the system does not tell: a folder without the
// right to search it, a name that is too long, a share that does not answer.
bool is_present(const std::string& path);

}  // namespace driftwise::storage
