#include "server/access/private_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "server/core/reasons.h"

namespace driftwise::access {
namespace {

tl::unexpected<Error> cannot_write(const std::string& path) {
  return fail(ErrorCode::unavailable, reasons::kCannotWrite,
              "cannot write " + path + ": " + std::strerror(errno));
}

bool write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const auto count = ::write(file, text.data(), text.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(count));
  }
  return true;
}

}  // namespace

Result<void> write_private_file(const std::string& path, std::string_view text) {
  const std::string part = path + ".part";
  ::unlink(part.c_str());
  const int file = ::open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (file < 0) return cannot_write(part);
  const bool written = write_all(file, text) && ::fsync(file) == 0;
  const int why = errno;
  ::close(file);
  errno = why;
  if (!written || std::rename(part.c_str(), path.c_str()) != 0) return cannot_write(path);
  const std::string folder = std::filesystem::path(path).parent_path().string();
  if (const int opened = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); opened >= 0) {
    ::fsync(opened);
    ::close(opened);
  }
  return {};
}

Result<std::optional<std::string>> read_private_file(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0 && errno == ENOENT) return std::optional<std::string>();
  struct stat about {};
  std::string text;
  bool good = file >= 0 && ::fstat(file, &about) == 0;
  std::array<char, 65'536> piece{};
  for (ssize_t count = 1; good && count > 0;) {
    count = ::read(file, piece.data(), piece.size());
    good = count >= 0;
    if (count > 0) text.append(piece.data(), static_cast<std::size_t>(count));
  }
  const int why = errno;
  if (file >= 0) ::close(file);
  if (!good)
    return fail(ErrorCode::unavailable, reasons::kCannotOpen,
                "cannot read " + path + ": " + std::strerror(why));
  if ((about.st_mode & 077U) != 0)
    return fail(ErrorCode::failed_precondition, reasons::kFileReadable,
                path + " holds secrets and is open to other users: chmod 600 " + path);
  return std::optional(std::move(text));
}

}  // namespace driftwise::access
