#include "server/watchdog/heads_log.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>
#include <utility>

#include "server/core/reasons.h"
#include "server/core/text/clean_text.h"

namespace driftwise::watchdog {

Result<HeadsLog> HeadsLog::open(std::string path) {
  const int file = ::open(path.c_str(), O_RDWR | O_APPEND | O_CREAT | O_CLOEXEC, 0600);
  if (file < 0)
    return fail(ErrorCode::not_found, reasons::kCannotOpen,
                "the file of heads, " + path + ", cannot be opened: " + std::strerror(errno));
  HeadsLog log(path, file);
  std::ifstream text(path);
  for (std::string line; std::getline(text, line);) {
    std::istringstream words(line);
    std::string at, head, cell;
    words >> at >> head >> std::ws;
    std::getline(words, cell);
    const auto instant = parse_iso8601(at);
    const auto kept = chain_head_from(head);
    if (instant && kept && !cell.empty()) log.newest_[cell] = {{instant->utc_ns}, *kept};
  }
  // What was cut off stays a line of its own.
  char last = '\n';
  if (const off_t end = ::lseek(file, 0, SEEK_END); end > 0)
    static_cast<void>(::pread(file, &last, 1, end - 1));
  if (last != '\n' && ::write(file, "\n", 1) != 1)
    return fail(ErrorCode::resource_exhausted, reasons::kDiskFull, path + " cannot be written");
  return log;
}

HeadsLog::HeadsLog(HeadsLog&& other) noexcept
    : path_(std::move(other.path_)),
      file_(std::exchange(other.file_, -1)),
      newest_(std::move(other.newest_)) {}

HeadsLog::~HeadsLog() {
  if (file_ >= 0) ::close(file_);
}

Result<void> HeadsLog::keep(const std::string& cell, UtcTime at, const ChainHead& head) {
  const std::string name = clean_line(cell);
  const auto known = newest_.find(name);
  if (head.entry == 0 || (known != newest_.end() && known->second.head == head)) return {};
  const std::string line = to_iso8601(at) + " " + to_string(head) + " " + name + "\n";
  const ssize_t written = ::write(file_, line.data(), line.size());
  if (written != static_cast<ssize_t>(line.size()) || ::fdatasync(file_) != 0)
    return fail(ErrorCode::resource_exhausted, reasons::kDiskFull,
                path_ + " cannot be written: " + std::strerror(errno) + ": make room on the disk");
  newest_[name] = {at, head};
  return {};
}

}  // namespace driftwise::watchdog
