#pragma once
// Stops that clients left beside the cell file or the record while no daemon answered (docs/cli.md,
// "Stop without a daemon").

#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "server/formats/text/kept_stop.h"

namespace driftwise {

// Path of the stop of a cell: beside its cell file.
std::filesystem::path kept_stop_of_cell(const std::string& cell_file);

// Any thread.
class KeptStopFile {
 public:
  explicit KeptStopFile(std::filesystem::path path) : path_(std::move(path)) {}

  // None: there is no such file, or the one that remove() could not remove. A file that cannot be
  // read is a stop by "somebody".
  std::optional<formats::KeptStop> read();
  // The stop of the last read() is in force by now. A file that stays is a stop at the next start
  // too: logged.
  void remove();
  // For the next start. What cannot be written is logged, with what a person has to do.
  void keep(const formats::KeptStop& stop);

 private:
  std::filesystem::path path_;
  std::mutex mutex_;
  std::filesystem::file_time_type read_at_{}, stays_{};  // times of writing
};

// Looks for the file twice a second, on a thread of its own, until it is destroyed: one that is
// written while the daemon starts, or hangs, is not left for its next start.
class KeptStopWatch {
 public:
  // file outlives this. stop: on that thread; returns when the stop is in force.
  KeptStopWatch(KeptStopFile& file, std::function<void(const formats::KeptStop&)> stop);

 private:
  std::jthread thread_;
};

}  // namespace driftwise
