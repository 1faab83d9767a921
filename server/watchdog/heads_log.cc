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
namespace {

// Behind what was cut off. Names of cells are clean: none has a tab.
constexpr std::string_view kCutMark = "\t(cut off)\n";

}  // namespace

Result<HeadsLog> HeadsLog::open(std::string path) {
  const int file = ::open(path.c_str(), O_RDWR | O_APPEND | O_CREAT | O_CLOEXEC, 0600);
  if (file < 0)
    return fail(ErrorCode::not_found, reasons::kCannotOpen,
                "the file of heads, " + path + ", cannot be opened: " + std::strerror(errno));
  HeadsLog log(path, file);
  std::ifstream text(path);
  for (std::string line; std::getline(text, line);) {
    if (text.eof()) {
      log.is_cut_ = true;
      break;
    }
    if ((line + "\n").ends_with(kCutMark)) continue;
    std::istringstream words(line);
    std::string at, head, cell;
    words >> at >> head >> std::ws;
    std::getline(words, cell);
    const auto instant = parse_iso8601(at);
    const auto kept = chain_head_from(head);
    if (instant && kept && !cell.empty()) log.newest_[cell] = {{instant->utc_ns}, *kept};
  }
  return log;
}

HeadsLog::HeadsLog(HeadsLog&& other) noexcept
    : path_(std::move(other.path_)),
      file_(std::exchange(other.file_, -1)),
      is_cut_(other.is_cut_),
      newest_(std::move(other.newest_)) {}

HeadsLog::~HeadsLog() {
  if (file_ >= 0) ::close(file_);
}

Result<void> HeadsLog::keep(const std::string& cell, UtcTime at, const ChainHead& head) {
  const std::string name = clean_line(cell);
  const auto known = newest_.find(name);
  if (head.entry == 0 || (known != newest_.end() && known->second.head == head)) return {};
  std::string line(is_cut_ ? kCutMark : "");
  line += to_iso8601(at) + " " + to_string(head) + " " + name + "\n";
  const ssize_t written = ::write(file_, line.data(), line.size());
  const bool is_whole = written == static_cast<ssize_t>(line.size());
  const std::string why = written < 0 ? std::strerror(errno) : "it was cut off";
  if (written > 0) is_cut_ = !is_whole;
  if (!is_whole)
    return fail(ErrorCode::resource_exhausted, reasons::kDiskFull,
                path_ + " cannot be written: " + why + ": make room on the disk");
  if (::fdatasync(file_) != 0)
    return fail(ErrorCode::resource_exhausted, reasons::kDiskFull,
                path_ + " cannot be written: " + std::strerror(errno) + ": make room on the disk");
  newest_[name] = {at, head};
  return {};
}

}  // namespace driftwise::watchdog
