#pragma once
// One line about work under way in the daemon: redrawn in place on a terminal, else a line whenever
// its step changes.

#include <string>

#include "clients/cli/core/console.h"

namespace driftwise::cli {

class JobBar {
 public:
  explicit JobBar(const Console& console) : console_(console) {}
  ~JobBar();  // leaves the line standing and ends it
  JobBar(const JobBar&) = delete;
  JobBar& operator=(const JobBar&) = delete;

  // fraction: 0 to 1; below 0: not known, no bar.
  void show(const std::string& what, double fraction, const std::string& step);

 private:
  const Console& console_;
  std::string last_;
  bool open_line_ = false;
};

}  // namespace driftwise::cli
