#include "clients/cli/core/session.h"

#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <utility>

#include "clients/cli/core/read_stream.h"
#include "server/core/force_to_disk.h"

namespace driftwise::cli {

std::string read_input_file(const std::string& path) {
  if (path == "-") return read_stream(std::cin, "standard input");
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    throw Failure{ExitCode::bad_input, "invalid_argument", "NOT_A_FILE",
                  path + " is a folder, expected a file"};
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw Failure{ExitCode::bad_input, "not_found", "NO_FILE",
                  "cannot read " + path + ": " + std::strerror(errno)};
  return read_stream(file, path);
}

std::string base_name(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

namespace {

std::ostream* standard_output = &std::cout;

Failure cannot_write(const std::string& path, const std::string& why) {
  return {ExitCode::bad_input, "invalid_argument", "CANNOT_WRITE",
          "cannot write " + path + ": " + why};
}

// Says why not, or nothing.
std::string write_to(const std::filesystem::path& file, const std::string& text) {
  errno = 0;
  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  if (out && (out << text).flush()) return {};
  return std::strerror(errno != 0 ? errno : EIO);
}

// Number of the open file that this path names: 1 of "-", "/dev/stdout" and "/proc/self/fd/1".
std::optional<int> open_file(const std::filesystem::path& path) {
  std::error_code ignored;
  if (path == "-") return STDOUT_FILENO;
  const auto folder = std::filesystem::canonical("/proc/self/fd", ignored);
  if (ignored || std::filesystem::canonical(path.parent_path(), ignored) != folder) return {};
  const std::string name = path.filename().string();
  int number = -1;
  const auto read = std::from_chars(name.data(), name.data() + name.size(), number);
  if (read.ec != std::errc() || read.ptr != name.data() + name.size()) return {};
  return number;
}

// Target of a link, also of one to a file that does not exist yet. What this process has open is a
// target too: behind it a link of the kernel's leads on to the file, where all that was written
// before would be replaced.
std::filesystem::path end_of_links(std::filesystem::path file) {
  constexpr int kMostLinks = 40;  // as the kernel
  std::error_code ignored;
  for (int i = 0; i < kMostLinks && !open_file(file); ++i) {
    if (!std::filesystem::is_symlink(file, ignored)) break;
    file = file.parent_path() / std::filesystem::read_symlink(file, ignored);
  }
  return file;
}

// Says why not, or nothing. Standard output through its stream, behind what stands there already.
std::string write_to_open(int number, const std::string& text) {
  if (number == STDOUT_FILENO) {
    *standard_output << text << std::flush;
    return {};
  }
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t written = ::write(number, text.data() + done, text.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return std::strerror(written < 0 ? errno : EIO);
    done += static_cast<std::size_t>(written);
  }
  return {};
}

}  // namespace

bool is_standard_output(const std::string& path) {
  return !path.empty() && open_file(end_of_links(path)) == STDOUT_FILENO;
}

std::ostream& set_standard_output(std::ostream& stream) {
  return *std::exchange(standard_output, &stream);
}

void write_output_file(const std::string& path, const std::string& text,
                       const std::vector<std::string>& read) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  for (const auto& file : read)
    if (fs::equivalent(path, file, ignored))
      throw cannot_write(path,
                         "it was read just now and may be the only copy of these data; give "
                         "another name");
  if (fs::is_directory(path, ignored))
    throw cannot_write(path, "it is a folder, expected the name of a file");
  const fs::path file = end_of_links(path);
  if (const auto number = open_file(file)) {
    if (const auto why = write_to_open(*number, text); !why.empty()) throw cannot_write(path, why);
    return;
  }
  // A file renamed over a device would take its place: as root even that of /dev/null.
  if (fs::exists(path, ignored) && !fs::is_regular_file(path, ignored)) {
    if (const auto why = write_to(path, text); !why.empty()) throw cannot_write(path, why);
    return;
  }
  const fs::path part = file.string() + ".part";
  auto why = write_to(part, text);
  errno = 0;
  if (why.empty() && !force_to_disk(part.c_str())) why = std::strerror(errno != 0 ? errno : EIO);
  if (why.empty() && std::rename(part.c_str(), file.c_str()) != 0) why = std::strerror(errno);
  if (why.empty()) {
    force_to_disk(fs::absolute(file).parent_path().c_str());
    return;
  }
  fs::remove(part, ignored);
  throw cannot_write(path, why);
}

}  // namespace driftwise::cli
