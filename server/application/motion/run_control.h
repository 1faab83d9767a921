#pragma once
// What people want of the run under way. Set by commands, looked at by the engine between two
// steps.

#include <cstdint>
#include <optional>
#include <string>

#include "server/application/plumbing/signal.h"
#include "server/core/description/hold_rule.h"
#include "server/core/reasons.h"
#include "server/core/records/records.h"
#include "server/core/result.h"

namespace driftwise::application {

// Condition of the cell that keeps a run waiting ([[hold]]), and the action before it waits.
struct CellCondition {
  RunHold hold;  // of kind condition
  HoldAction action = HoldAction::finish_point;
};

class RunControl {
 public:
  explicit RunControl(const asio::any_io_executor& executor) : changed_(executor) {}

  // The run holds after the present point (or where it waits) until resume(). A person's stop that
  // is in force stays what has to be ended: a pause after it does not make it weaker.
  void hold(RunHold hold) {
    const bool is_weaker = hold.kind != RunHold::Kind::stop;
    if (!(hold_.kind == RunHold::Kind::stop && is_weaker)) hold_ = std::move(hold);
    changed_.raise();
  }
  // The axes were stopped: the step under way ends at once with RUN_HALTED, and the run holds as it
  // does after hold(). The row under way is visited again.
  void halt(RunHold why) {
    halt_ = Halt::by_person;
    hold(std::move(why));
  }
  // Condition of the cell now; none: nothing keeps the run. It ends by itself, and never ends what
  // a person, or the daemon that asks for one, has set. Of two that follow each other without a gap
  // the first one's words stay; one that halted the run stays until the engine has seen the halt.
  // True: the run is halted by it now, and who set it stops the axes.
  [[nodiscard]] bool set_condition(std::optional<CellCondition> condition) {
    if (condition.has_value() == condition_.has_value() &&
        (!condition || condition->action == condition_->action))
      return false;
    if (!condition && halted_by_cell()) return false;
    if (condition && condition_) condition->hold = condition_->hold;
    const bool stops = condition && condition->action >= HoldAction::stop;
    condition_ = std::move(condition);
    if (stops && halt_ == Halt::none) halt_ = Halt::by_cell;
    changed_.raise();
    return stops;
  }
  bool wants_zero() const { return condition_ && condition_->action == HoldAction::return_to_zero; }
  // The engine has seen the halt; the hold stays.
  void take_halt() { halt_ = Halt::none; }
  void resume() {
    hold_ = {};
    changed_.raise();
  }
  // The run waits until a person says that this force acts.
  void want_force(double force_n) { wanted_force_n_ = force_n; }
  const std::optional<double>& wanted_force() const { return wanted_force_n_; }
  // ... or its step ends without that.
  void want_no_force() { wanted_force_n_.reset(); }
  void confirm_force() {
    wanted_force_n_.reset();
    changed_.raise();
  }
  void abort(std::string why) {
    if (aborted_) return;
    aborted_ = true;
    abort_reason_ = std::move(why);
    changed_.raise();
  }
  // The daemon ends: the run keeps its state and goes on with the next start.
  void shut_down() {
    shutting_down_ = true;
    changed_.raise();
  }

  bool held() const { return hold_.kind != RunHold::Kind::none || condition_; }
  bool halted() const { return halt_ != Halt::none && !aborted_ && !shutting_down_; }
  // By a condition of the cell and by nobody else.
  bool halted_by_cell() const { return halt_ == Halt::by_cell; }
  bool aborted() const { return aborted_; }
  bool shutting_down() const { return shutting_down_; }
  // A person's hold comes before that of the cell.
  const RunHold& hold() const {
    return hold_.kind == RunHold::Kind::none && condition_ ? condition_->hold : hold_;
  }
  // Errors: aborted RUN_ABORTED or RUN_HALTED, cancelled SHUTTING_DOWN. A hold is no error: the
  // engine asks held() after a point.
  Result<void> check() const {
    if (shutting_down_)
      return fail(ErrorCode::cancelled, reasons::kShuttingDown, "the daemon is shutting down");
    if (aborted_) return fail(ErrorCode::aborted, reasons::kRunAborted, abort_reason_);
    if (halt_ != Halt::none) return fail(ErrorCode::aborted, reasons::kRunHalted, hold().reason);
    return {};
  }
  Signal& changed() { return changed_; }

 private:
  enum class Halt : std::uint8_t { none, by_cell, by_person };  // by_person: or the daemon's doubt
  Halt halt_ = Halt::none;
  bool aborted_ = false, shutting_down_ = false;
  RunHold hold_;  // by a person, or because the daemon asks for one
  std::optional<CellCondition> condition_;
  std::string abort_reason_;
  std::optional<double> wanted_force_n_;
  Signal changed_;
};

}  // namespace driftwise::application
