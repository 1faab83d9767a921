#pragma once
// One line about work under way in the daemon: redrawn in place on a terminal, else a line whenever
// what it does changes, and every half minute.

#include <chrono>
#include <functional>
#include <string>

#include "clients/cli/core/console.h"

namespace driftwise::cli {

class JobBar {
 public:
  using Now = std::function<std::chrono::steady_clock::time_point()>;
  static constexpr std::chrono::seconds kBetweenLines{30};  // of the same work in a log

  explicit JobBar(const Console& console, Now now = std::chrono::steady_clock::now)
      : console_(console), now_(std::move(now)) {}
  ~JobBar();  // leaves the line standing and ends it
  JobBar(const JobBar&) = delete;
  JobBar& operator=(const JobBar&) = delete;

  // fraction: 0 to 1; below 0: not known, no bar. step: what is done, then after ": " how far it
  // is: "measuring 40 points: 12 of 40, reading".
  void show(const std::string& what, double fraction, const std::string& step);

 private:
  const Console& console_;
  Now now_;
  std::string work_;  // as the log was last told
  std::chrono::steady_clock::time_point told_at_{};
  bool open_line_ = false;
};

}  // namespace driftwise::cli
