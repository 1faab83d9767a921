#include "storage/sqlite/present_file.h"

#include <filesystem>

#include "storage/sqlite/failure.h"

namespace driftwise::storage {

bool is_present(const std::string& path) {
  std::error_code failed;
  const bool found = std::filesystem::exists(path, failed);
  if (failed)
    throw_failure(ErrorCode::not_found, reasons::kCannotOpen,
                  "file " + path + " cannot be looked for: " + failed.message() +
                      "; look at the path and at the rights of its folder");
  return found;
}

}  // namespace driftwise::storage
