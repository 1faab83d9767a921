#include "server/notify/secret_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "server/core/reasons.h"

namespace driftwise::notify {

Result<std::string> read_secret(const std::string& path) {
  const auto bad = [&path](const std::string& found) {
    return fail(ErrorCode::failed_precondition, reasons::kBadSecretFile,
                "secret file " + path + ": " + found +
                    "; expected a file of one line that only its owner may read (chmod 600)");
  };
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return bad(std::strerror(errno));
  struct stat state {};
  std::array<char, 4096> bytes{};
  const bool looked = ::fstat(file, &state) == 0;
  const ssize_t read =
      looked && S_ISREG(state.st_mode) ? ::read(file, bytes.data(), bytes.size()) : ssize_t{-1};
  ::close(file);
  if (read < 0) return bad("it cannot be read");
  if ((state.st_mode & 077) != 0) return bad("others than its owner may read or change it");
  std::string line(bytes.data(), static_cast<std::size_t>(read));
  line = line.substr(0, line.find('\n'));
  if (line.ends_with('\r')) line.pop_back();
  if (line.empty() || line.size() >= bytes.size())
    return bad("its first line is empty or too long");
  return line;
}

}  // namespace driftwise::notify
