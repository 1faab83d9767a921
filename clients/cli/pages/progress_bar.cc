#include "clients/cli/pages/progress_bar.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/pages/band_text.h"
#include "clients/cli/pages/run_text.h"

namespace driftwise::cli {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr int kBarCells = 20;

std::int64_t decided(const v1::Run& run) { return run.accepted_count() + run.given_up_count(); }

double share_of(const v1::Run& run) {
  if (run.row_count() <= 0) return 0;
  return std::clamp(static_cast<double>(decided(run)) / static_cast<double>(run.row_count()), 0.0,
                    1.0);
}

}  // namespace

std::string progress_line(const v1::RunProgress& progress, double remaining_s, int width) {
  const v1::Run& run = progress.run();
  const double share = share_of(run);
  const auto filled = static_cast<std::size_t>(std::floor(share * kBarCells));
  const bool under_way = run.state() == v1::Run::STATE_RUNNING && !progress.phase().empty();
  std::string line = "run " + std::to_string(run.id()) + " " +
                     (under_way ? progress.phase() : state_text(run.state()));
  line += " [" + std::string(filled, '#') + std::string(kBarCells - filled, '.') + "]  " +
          std::to_string(decided(run)) + "/" + std::to_string(run.row_count()) + "  " +
          fixed(std::floor(share * 100), 0) + " %";
  std::vector<std::string> more;
  if (run.given_up_count() > 0) more.push_back(std::to_string(run.given_up_count()) + " given up");
  const bool held = !under_way && !is_over(run.state()) && progress.has_remaining_duration();
  if (under_way && remaining_s >= 1) more.push_back(span_text(remaining_s) + " left");
  if (held)
    more.push_back(span_text(seconds_of(progress.remaining_duration())) +
                   " of cell time left once it goes on" +
                   (progress.has_remaining_band()
                        ? " (" + band_text(progress.remaining_band()) + ")"
                        : std::string()));
  if (progress.has_latest_end_time() && !held)
    more.push_back("ends " +
                   end_text(progress.estimated_end_time(), progress.earliest_end_time(),
                            progress.latest_end_time(), progress.remaining_band().share()) +
                   " UTC");
  else if (progress.has_estimated_end_time() && !held)
    more.push_back("ends " + clock_text(progress.estimated_end_time()).substr(11) + " UTC");
  if (progress.has_last_spread_nm())
    more.push_back("spread " + fixed(progress.last_spread_nm(), 1) + " nm");
  if (progress.has_last_closure_nm())
    more.push_back("closure " + signed_fixed(progress.last_closure_nm(), 0) + " nm");
  for (const auto& text : more)
    if (width_of(line) + 2 + width_of(text) < static_cast<std::size_t>(width)) line += "  " + text;
  return line;
}

ProgressBar::ProgressBar(const Console& console, const v1::GetStatusResponse& status)
    : console_(console), status_(status), asked_(std::chrono::steady_clock::now()) {}

ProgressBar::~ProgressBar() {
  if (open_line_) console_.err << '\n' << std::flush;
}

double ProgressBar::remaining_s(const v1::RunProgress& progress) const {
  if (!progress.has_estimated_end_time() || status_.speed() <= 0) return kUnknown;
  const double since_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - asked_).count();
  return seconds_between(status_.cell_time(), progress.estimated_end_time()) / status_.speed() -
         since_s;
}

bool ProgressBar::may_tell_state(v1::Run::State state) {
  const auto now = std::chrono::steady_clock::now();
  if (states_left_ == kStatesAtOnce) refilled_ = now;
  while (states_left_ < kStatesAtOnce && now - refilled_ >= kRefill) {
    ++states_left_;
    refilled_ += kRefill;
  }
  if (is_over(state)) return true;
  if (states_left_ == 0) return false;
  --states_left_;
  return true;
}

void ProgressBar::show(const v1::RunProgress& progress) {
  const auto now = std::chrono::steady_clock::now();
  const auto& run = progress.run();
  const bool changed = run.state() != last_state_ || run.reason() != last_reason_;
  last_state_ = run.state();
  last_reason_ = run.reason();
  const std::string why = is_over(run.state()) ? "" : run.reason();
  if (!console_.err_is_terminal) {  // a log wants few lines: state changes and every tenth
    const int tenth = static_cast<int>(std::floor(share_of(run) * 10));
    if (tenth == last_tenth_ && !(changed && may_tell_state(last_state_))) return;
    last_tenth_ = tenth;
    console_.err << progress_line(progress, remaining_s(progress), 200)
                 << (why.empty() ? "" : "  (" + why + ")") << '\n'
                 << std::flush;
    return;
  }
  if (!changed && now - drawn_ < std::chrono::milliseconds(100)) return;
  drawn_ = now;
  if (changed && !why.empty() && may_tell_state(run.state()))
    console_.err << "\r\x1b[Krun " << run.id() << " " << state_text(run.state()) << ": " << why
                 << '\n';
  console_.err << "\r\x1b[K" << progress_line(progress, remaining_s(progress), console_.err_width)
               << std::flush;
  open_line_ = true;
}

}  // namespace driftwise::cli
