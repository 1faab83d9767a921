#pragma once
// The heads of the records' chains that cells have told, with the instant at which they arrived: a
// text file, one line each, "2026-11-22T22:50:00Z HASH@N cell-a". Lines are added, never changed;
// each is on the disk before the sign of life is answered. A head that is the cell's last one adds
// none. One thread.

#include <map>
#include <string>

#include "server/core/records/audit_records.h"
#include "server/core/result.h"
#include "server/core/utc_map.h"

namespace driftwise::watchdog {

class HeadsLog {
 public:
  struct Kept {
    UtcTime at;
    ChainHead head;
  };

  // Makes the file where there is none (mode 0600), reads the newest head of each cell. A line
  // without its end was cut off, by a loss of power or a full disk: wherever the cut is, it is no
  // line, and a mark behind it says so to later starts. Errors: not_found CANNOT_OPEN.
  static Result<HeadsLog> open(std::string path);
  HeadsLog(HeadsLog&& other) noexcept;
  HeadsLog& operator=(HeadsLog&&) = delete;
  ~HeadsLog();

  // Errors: resource_exhausted DISK_FULL.
  Result<void> keep(const std::string& cell, UtcTime at, const ChainHead& head);
  const std::map<std::string, Kept>& newest() const { return newest_; }  // by cell

 private:
  HeadsLog(std::string path, int file) : path_(std::move(path)), file_(file) {}

  std::string path_;
  int file_;
  bool is_cut_ = false;  // the file ends within a line
  std::map<std::string, Kept> newest_;
};

}  // namespace driftwise::watchdog
