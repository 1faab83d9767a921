// The engine's question who says that the robot may move: after a restart, a power loss, and before
// a run that begins by itself.

#include <fmt/format.h>

#include "server/application/ports/run_hold.h"
#include "server/application/runs/run_engine.h"
#include "server/core/try.h"

namespace driftwise::application {

// Before every datum: after a restart, or where the axes have lost the reference that they had when
// motion was asked for, who says that the robot may move. Nothing has moved yet. Where the run is
// held by then, nobody has said it: it is asked again after the hold.
Awaitable<Result<void>> RunEngine::clear_to_move(ActiveRun& run) {
  if (!begins_by_itself_.empty()) {
    if (auto ok = co_await announce_motion(run, begins_by_itself_); !ok) co_return ok;
    if (run.control.held()) co_return Result<void>{};
    begins_by_itself_.clear();
  }
  DRIFTWISE_CO_TRY(const auto state, co_await bench_.devices.motion_state());
  // The first look since a person asked: the controller did not answer then.
  if (!referenced_ && switch_on_ == SwitchOn::yes) co_await note_reference(state.referenced);
  const bool reference_lost = has_lost_reference(state.referenced);
  if (may_start_ && !reference_lost) co_return Result<void>{};
  const bool power_loss = computer_was_away_ || reference_lost;
  const auto& rules = bench_.description.restart;
  std::string why = "the daemon was away while the run was under way";
  if (computer_was_away_)
    why = "the computer was started anew while the run was under way";
  else if (reference_lost)
    why = fmt::format(
        "the controller {} while the {}",
        referenced_ ? "has lost its reference" : "did not answer, and has no reference,",
        before_ && !may_start_ ? "daemon was away" : "run was under way");
  const auto wish = power_loss ? rules.after_power_loss : rules.after_restart;
  may_start_ = false;
  if (wish == AfterAway::wait) {
    run.control.hold({RunHold::Kind::restart, "", bench_.clock.now().utc,
                      fmt::format("{}: look at the machine, then resume it ([run] {} = \"wait\")",
                                  why, power_loss ? "after_power_loss" : "after_restart")});
    if (auto ok = co_await hold(run, RunState::paused); !ok) co_return ok;
    if (auto ok = co_await use_permission(run); !ok) co_return ok;
  } else if (power_loss) {
    why += ", and the cell file says to go on ([run] after_power_loss = \"go-on\")";
    if (auto ok = co_await announce_motion(run, why); !ok) co_return ok;
    if (run.control.held()) co_return Result<void>{};
    switch_on_ = SwitchOn::if_unreferenced;
    co_await note_reference(state.referenced);
  }
  may_start_ = true;
  computer_was_away_ = false;
  co_return Result<void>{};
}

// The robot is about to move without anybody having asked for it now: a minute for a person to stop
// it, or to pause the run. What holds the run ends the minute.
Awaitable<Result<void>> RunEngine::announce_motion(ActiveRun& run, const std::string& why) {
  constexpr double kWarning_s = 60;
  const auto begins = bench_.clock.now().utc + nanoseconds_from_s(kWarning_s);
  announcement_ =
      fmt::format("run {} moves the robot at {}: {}; a stop or a pause keeps it from moving",
                  run.record.id.value, to_iso8601(bench_.clock.utc(begins)), why);
  bench_.events.record_own("run.moves_soon", announcement_, run.record.id);
  run.scope.phase("about to move");
  Result<void> waited = run.control.check();
  while (waited && !run.control.held() && bench_.clock.now().utc < begins) {
    co_await sleep_unless(bench_.clock, begins, run.control.changed());
    waited = run.control.check();
  }
  announcement_.clear();
  co_return waited;
}

}  // namespace driftwise::application
