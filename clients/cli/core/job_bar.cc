#include "clients/cli/core/job_bar.h"

#include <algorithm>
#include <cmath>

#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"

namespace driftwise::cli {

JobBar::~JobBar() {
  if (open_line_) console_.err << '\n' << std::flush;
}

void JobBar::show(const std::string& what, double fraction, const std::string& step) {
  if (console_.json) return;
  if (!console_.err_is_terminal) {
    if (step.empty()) return;
    const auto now = now_();
    const std::string work = what + ": " + step.substr(0, step.find(": "));
    if (work == work_ && now - told_at_ < kBetweenLines) return;
    work_ = work;
    told_at_ = now;
    console_.err << what << ": " << step << '\n' << std::flush;
    return;
  }
  constexpr double kCells = 20;
  std::string line = what + " ";
  if (fraction >= 0) {
    const auto filled =
        static_cast<std::size_t>(std::floor(std::clamp(fraction, 0.0, 1.0) * kCells));
    line += "[" + std::string(filled, '#') + std::string(20 - filled, '.') + "] " +
            fixed(std::floor(100 * fraction), 0) + " %  ";
  }
  line += step;
  const auto width = static_cast<std::size_t>(std::max(20, console_.err_width - 1));
  if (width_of(line) > width) line = line.substr(0, width);
  console_.err << "\r\x1b[K" << line << std::flush;
  open_line_ = true;
}

}  // namespace driftwise::cli
