#pragma once
// Where clients find this daemon: driftwised.json beside the cell file, in one piece, there only
// while the daemon is ready.

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>

namespace driftwise {

// Any thread. Where the file cannot be written, on a full disk say, the log has why, no part of it
// is left, and it is tried again on a thread of its own until it stands.
class NoticeFile {
 public:
  NoticeFile(const std::string& cell_file, std::string content,
             std::chrono::milliseconds again_after = std::chrono::seconds(10));
  ~NoticeFile();  // and the file goes
  NoticeFile(const NoticeFile&) = delete;
  NoticeFile& operator=(const NoticeFile&) = delete;

 private:
  std::string write() const;  // why not; empty: it stands

  std::filesystem::path path_;
  std::string content_;
  std::jthread again_;
};

}  // namespace driftwise
