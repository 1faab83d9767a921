#pragma once
// Several texts as one .tar.gz: ustar (POSIX.1-1988) in gzip (RFC 1952).

#include <cstdint>
#include <string>
#include <vector>

#include "server/core/result.h"

namespace driftwise::formats {

struct ArchiveMember {
  std::string name;  // "bundle/status.json": at most 99 bytes
  std::string text;
};

// utc_s: the time of every member. The same members give the same bytes. Errors, invalid_argument:
// TOO_LONG (a name); internal ALL_DROPPED (zlib refused).
Result<std::string> tar_gz(const std::vector<ArchiveMember>& members, std::int64_t utc_s);

}  // namespace driftwise::formats
