#include "server/application/ports/run_hold.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "server/core/reasons.h"
#include "server/core/records/state_text.h"

namespace driftwise::application {
namespace {

std::string age_text(double seconds) {
  constexpr double kMinute_s = 60, kHour_s = 3600, kDay_s = 86400;
  if (seconds < 2 * kMinute_s) return fmt::format("{:.0f} s", std::max(0.0, seconds));
  if (seconds < 2 * kHour_s) return fmt::format("{:.0f} min", seconds / kMinute_s);
  if (seconds < 2 * kDay_s) return fmt::format("{:.1f} h", seconds / kHour_s);
  return fmt::format("{:.1f} days", seconds / kDay_s);
}

}  // namespace

std::string hold_sentence(const RunRecord& run, const RunHold& hold, CellTime now) {
  const std::string ago = age_text(seconds_from(now - hold.at));
  switch (hold.kind) {
    case RunHold::Kind::none:
      break;
    case RunHold::Kind::pause:
      return fmt::format("run {} was paused by {} {} ago", run.id.value, hold.who, ago);
    case RunHold::Kind::stop:
      return fmt::format("run {} was stopped by {} {} ago", run.id.value, hold.who, ago);
    case RunHold::Kind::condition:
      return fmt::format("run {} waits since {} for the cell: {}", run.id.value, ago, hold.reason);
    case RunHold::Kind::trouble:
    case RunHold::Kind::restart:
    case RunHold::Kind::configuration:
      return fmt::format("run {} asks for a person since {}: {}", run.id.value, ago, hold.reason);
  }
  return fmt::format("run {} {}", run.id.value, is_text(run.state));
}

RunHold stored_hold(const RunRecord& run, CellTime now) {
  if (run.hold.kind != RunHold::Kind::none && run.hold.reason == run.reason) return run.hold;
  constexpr std::string_view kStopped = "stopped by ", kPaused = "paused by ";
  RunHold hold{RunHold::Kind::trouble, "", now, run.reason};
  if (run.reason.starts_with(kStopped)) {
    hold.kind = RunHold::Kind::stop;
    hold.who = run.reason.substr(kStopped.size());
  } else if (run.reason.starts_with(kPaused)) {
    hold.kind = RunHold::Kind::pause;
    hold.who = run.reason.substr(kPaused.size());
  }
  return hold;
}

Result<void> check_answer(const RunRecord& run, const RunHold& hold, const std::string& name,
                          const HoldAnswer& answer, CellTime now) {
  const std::string what = hold_sentence(run, hold, now);
  if (hold.kind == RunHold::Kind::none)
    return fail(ErrorCode::failed_precondition, reasons::kNotPaused,
                what + ": there is no pause or stop to end");
  if (hold.kind == RunHold::Kind::condition)
    return fail(ErrorCode::failed_precondition, reasons::kHeldByCell,
                what +
                    ". It goes on by itself when the limits are met; 'driftwise hold aside NAME "
                    "--for 1h --reason ...' sets a limit aside");
  if (answer.hold_id != hold.id())
    return fail(ErrorCode::failed_precondition, reasons::kHoldNotNamed,
                fmt::format("{}; the request names {} instead of this ({}): look at the machine, "
                            "then answer the question of the page or of the command line",
                            what,
                            answer.hold_id == 0 ? std::string("no pause or stop")
                                                : fmt::format("another one ({})", answer.hold_id),
                            hold.id()));
  const bool has_reason = answer.override_reason.find_first_not_of(" \t\r\n") != std::string::npos;
  if (hold.kind == RunHold::Kind::stop && hold.who != name && !has_reason)
    return fail(ErrorCode::failed_precondition, reasons::kStoppedByAnother,
                fmt::format("{}: {} resumes it, or {} gives a reason in writing, which is recorded "
                            "(--override REASON)",
                            what, hold.who, name));
  return {};
}

}  // namespace driftwise::application
