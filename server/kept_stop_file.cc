#include "server/kept_stop_file.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <fstream>

#include "server/core/force_to_disk.h"

namespace driftwise {

namespace fs = std::filesystem;

fs::path kept_stop_of_cell(const std::string& cell_file) {
  return fs::absolute(cell_file).parent_path() / formats::kKeptStopFile;
}

std::optional<formats::KeptStop> KeptStopFile::read() {
  constexpr std::size_t kMost = 4096;
  const std::lock_guard lock(mutex_);
  std::error_code ignored;
  if (!fs::exists(fs::symlink_status(path_, ignored))) return std::nullopt;
  read_at_ = fs::last_write_time(path_, ignored);
  if (read_at_ == stays_) return std::nullopt;
  std::string text;
  if (fs::is_regular_file(path_, ignored)) {
    std::ifstream file(path_, std::ios::binary);
    text.resize(kMost);
    file.read(text.data(), static_cast<std::streamsize>(kMost));
    text.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, file.gcount())));
  }
  return formats::read_kept_stop(text);
}

void KeptStopFile::remove() {
  const std::lock_guard lock(mutex_);
  std::error_code failed;
  fs::remove(path_, failed);
  if (!failed) return;
  stays_ = read_at_;
  spdlog::warn("cannot remove {}: {}; the next start stops the axes again: remove it by hand",
               path_.string(), failed.message());
}

void KeptStopFile::keep(const formats::KeptStop& stop) {
  const std::lock_guard lock(mutex_);
  std::ofstream file(path_, std::ios::binary | std::ios::trunc);
  file << formats::write_kept_stop(stop);
  file.close();
  const bool kept = file && force_to_disk(path_.c_str());
  if (kept) force_to_disk(path_.parent_path().c_str());
  if (kept)
    spdlog::warn(
        "the record does not say that {} stopped the cell: {} says so to the next start, which "
        "moves "
        "nothing until a person has said so",
        stop.who, path_.string());
  else
    spdlog::error(
        "the record does not say that {} stopped the cell, and {} cannot be written: the next "
        "start "
        "lets the run go on. Before it, once the disk is well, enter {} and say 'driftwise stop'",
        stop.who, path_.string(), path_.parent_path().string());
}

KeptStopWatch::KeptStopWatch(KeptStopFile& file, std::function<void(const formats::KeptStop&)> stop)
    : thread_([&file, stop = std::move(stop)](const std::stop_token& ending) {
        constexpr auto kLookEvery = std::chrono::milliseconds(500);
        std::mutex mutex;
        std::condition_variable_any woken;
        std::unique_lock lock(mutex);
        while (!ending.stop_requested()) {
          if (const auto kept = file.read()) {
            stop(*kept);
            file.remove();
          }
          woken.wait_for(lock, ending, kLookEvery, [] { return false; });
        }
      }) {}

}  // namespace driftwise
