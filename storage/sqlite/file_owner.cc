#include "storage/sqlite/file_owner.h"

#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

namespace driftwise::storage {

void give_to_owner_of_folder(const std::string& path) {
  if (::geteuid() != 0) return;
  struct stat folder {};
  if (::stat(std::filesystem::absolute(path).parent_path().c_str(), &folder) != 0) return;
  // A share that does not let root do this leaves the file root's, and the daemon names it.
  if (::lchown(path.c_str(), folder.st_uid, folder.st_gid) != 0) return;
}

}  // namespace driftwise::storage
