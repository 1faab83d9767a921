#include "server/notice_file.h"

#include <spdlog/spdlog.h>

#include <cerrno>
#include <condition_variable>
#include <fstream>
#include <mutex>
#include <utility>

namespace driftwise {

namespace fs = std::filesystem;

NoticeFile::NoticeFile(const std::string& cell_file, std::string content,
                       std::chrono::milliseconds again_after)
    : path_(fs::absolute(cell_file).parent_path() / "driftwised.json"),
      content_(std::move(content)) {
  const std::string why = write();
  if (why.empty()) return;
  spdlog::warn("cannot write {}: {}; clients need --server meanwhile, it is tried again",
               path_.string(), why);
  again_ = std::jthread([this, again_after](const std::stop_token& ending) {
    std::mutex mutex;
    std::condition_variable_any woken;
    std::unique_lock lock(mutex);
    while (!woken.wait_for(lock, ending, again_after, [] { return false; }) &&
           !ending.stop_requested())
      if (write().empty()) return spdlog::info("{} is written", path_.string());
  });
}

NoticeFile::~NoticeFile() {
  again_.request_stop();
  if (again_.joinable()) again_.join();
  std::error_code ignored;
  fs::remove(path_, ignored);
}

std::string NoticeFile::write() const {
  const fs::path part = path_.string() + ".part";
  std::error_code failed, ignored;
  errno = 0;
  std::ofstream file(part, std::ios::binary | std::ios::trunc);
  file << content_;
  file.close();
  if (!file) failed.assign(errno != 0 ? errno : EIO, std::generic_category());
  // Addresses are no secret: whoever may enter the folder may read them, whatever the umask of the
  // service keeps of the other files.
  constexpr auto kReadable = fs::perms::owner_read | fs::perms::owner_write |
                             fs::perms::group_read | fs::perms::others_read;
  if (!failed) fs::permissions(part, kReadable, failed);
  if (!failed) fs::rename(part, path_, failed);
  if (!failed) return {};
  fs::remove(part, ignored);
  return failed.message();
}

}  // namespace driftwise
