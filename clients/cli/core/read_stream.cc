#include "clients/cli/core/read_stream.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <vector>

#include "clients/cli/core/console.h"

namespace driftwise::cli {
namespace {

Failure unreadable(const char* reason, const std::string& message) {
  return {ExitCode::bad_input, "invalid_argument", reason, message};
}

// Zero bytes in even and in odd places. UTF-16 of tables has them in one of the two only.
class Zeros {
 public:
  void count(std::string_view block, std::size_t begin) {
    for (std::size_t i = 0; i < block.size(); ++i)
      if (block[i] == '\0') ++count_[(begin + i) % 2];
  }
  // A compressed table (gzip, RFC 1952) is no text and may be one.
  static bool compressed(std::string_view text) { return text.starts_with("\x1f\x8b"); }
  bool tell_of_no_text(std::size_t bytes) const {
    return std::min(count_[0], count_[1]) > bytes / 2000 + 1;
  }

 private:
  std::array<std::size_t, 2> count_{};
};

}  // namespace

std::string read_stream(std::istream& stream, const std::string& name, std::size_t most_bytes) {
  std::string text;
  Zeros zeros;
  std::vector<char> block(std::size_t{1} << 16);
  while (stream) {
    errno = 0;
    std::size_t count = 0;
    try {  // libstdc++ throws inside the buffer when a read fails
      stream.read(block.data(), static_cast<std::streamsize>(block.size()));
      count = static_cast<std::size_t>(stream.gcount());
    } catch (const std::ios_base::failure&) {
      stream.setstate(std::ios_base::badbit);
    }
    if (stream.bad())
      throw unreadable("CANNOT_READ",
                       "cannot read " + name + ": " + std::strerror(errno != 0 ? errno : EIO));
    zeros.count({block.data(), count}, text.size());
    text.append(block.data(), count);
    if (!Zeros::compressed(text) && zeros.tell_of_no_text(text.size()))
      throw unreadable("NOT_TEXT", name + ": found zero bytes among the first " +
                                       std::to_string(text.size()) + " bytes, expected text");
    if (text.size() > most_bytes)
      throw unreadable("TOO_LARGE", name + ": found more than " + std::to_string(most_bytes >> 20) +
                                        " MiB, expected a table: a larger one is read from a file");
  }
  return text;
}

}  // namespace driftwise::cli
