#pragma once
// Going somewhere and being sure of it: soft limits, in position by the scale, quiet.

#include <limits>
#include <string>
#include <vector>

#include "server/application/motion/point_decision.h"
#include "server/application/motion/workbench.h"

namespace driftwise::application {

// One entry per axis, all axes of the cell, in order; those that do not move are not looked at.
// Errors, out_of_range SOFT_LIMIT: axis, asked, limits, what to do.
Result<void> check_soft_limits(const CellDescription& description, const std::vector<double>& q_mm,
                               const AxesToMove& moved = {});

// Places of all axes, mm; moving, referenced and on target as the controllers of the moved axes say
// it: one that nobody moves is not waited for. Errors: those of DeviceBench::motion_states.
Awaitable<Result<MotionState>> state_of(DeviceBench& devices, AxesToMove moved);

AxesToMove no_axes(const CellDescription& cell);  // all stay

// The same before a motion of `moved`. An axis under way whose controller is not told anew may be
// anywhere by its end, so no keep-out rule can be judged. Errors besides: failed_precondition
// MOVING: which axis, what to do.
Awaitable<Result<MotionState>> state_before(Workbench& bench, AxesToMove moved);

// The same before a motion in a run, which halts such an axis itself; by hand a person does.
Awaitable<Result<MotionState>> state_before(RunScope& scope, AxesToMove moved);

// The time limit of a move: move_timeout_s after the farthest axis last came nearer to its target
// by in_position_nm. A long or slow move takes as long as it takes.
class MoveLimit {
 public:
  MoveLimit(const RunRules& rules, CellTime begin)
      : step_nm_(rules.in_position_nm),
        longest_(nanoseconds_from_s(rules.move_timeout_s)),
        progress_(begin) {}
  // off_nm: of the farthest axis; infinite: not known.
  bool has_passed(double off_nm, CellTime now) {
    if (off_nm < nearest_nm_ - step_nm_) {
      nearest_nm_ = off_nm;
      progress_ = now;
    }
    return now - progress_ > longest_;
  }

 private:
  double step_nm_, nearest_nm_ = std::numeric_limits<double>::infinity();
  Nanoseconds longest_;
  CellTime progress_;
};

struct Arrival {
  Trouble trouble = Trouble::none;
  std::string
      sentence;       // empty without trouble: "quiet to 75 nm peak to peak over 2 s, limit 60 nm"
  Stamp in_position;  // the end of the move
  std::vector<double> q_mm;  // read back then, one per axis
};

// Error of a movement by hand that ended other than as commanded, with the axes at rest: in a run
// the engine halts them, and a stop that a person pressed has its own desk. NOT_SETTLED, whatever
// ended it: the controller does not say that they rest. SHUTTING_DOWN at the end of the daemon,
// which brings them to rest itself.
Awaitable<Error> halted_by_hand(RunScope& scope, Error ended);
Awaitable<Result<void>> halt_by_hand(RunScope& scope);  // where it ended without an error

// Moves and waits until the controllers say on target, the scales agree within in_position_nm, and
// the scales stay within quiet_nm peak to peak over settle_s: those of the axes that move. q_mm:
// one per axis of the cell; kMissing for an axis that does not move: it stays where it is. No
// arrival within MoveLimit, or no quiet within move_timeout_s after it, is Trouble::not_settled and
// no error; without arrival the axes are halted, whatever the controller says of their motion: one
// that is held up goes on when its way is free. The move itself is recorded for the store,
// cause: "row 17". RunScope::at_rest is then since when the scales have been quiet. Errors: those
// of the controller; out_of_range, SOFT_LIMIT and KEEP_OUT (in a run one robot moves before the
// others where that keeps the distance); failed_precondition MOVING; deadline_exceeded NOT_SETTLED:
// the controller reports motion after the halt; aborted and cancelled by the run's control. By hand
// the axes are halted after an error or a trouble of the way (halted_by_hand), in a run by the
// engine. Keeps RunScope::sides, and
// in a run RunScope::passed.
void note_sides(RunScope& scope, const std::vector<double>& from_mm,
                const std::vector<double>& to_mm);
Awaitable<Result<Arrival>> go_to(RunScope& scope, std::vector<double> q_mm, std::string cause,
                                 AxesToMove moved = {});

}  // namespace driftwise::application
