#pragma once
// Going somewhere and being sure of it: soft limits, in position by the scale, quiet.

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

struct Arrival {
  Trouble trouble = Trouble::none;
  std::string
      sentence;       // empty without trouble: "quiet to 75 nm peak to peak over 2 s, limit 60 nm"
  Stamp in_position;  // the end of the move
};

// Moves and waits until the controllers say on target, the scales agree within in_position_nm, and
// the scales stay within quiet_nm peak to peak over settle_s: those of the axes that move. q_mm:
// one per axis of the cell; kMissing for an axis that does not move: it stays where it is. Not
// arriving within move_timeout_s, or no quiet within the same time after that, is
// Trouble::not_settled and no error. The move itself is recorded for the store, cause: "row 17".
// RunScope::at_rest is then since when the scales have been quiet. Errors: those of the controller;
// out_of_range, SOFT_LIMIT and KEEP_OUT (in a run one robot moves before the others where that
// keeps the distance); aborted and cancelled by the run's control. Keeps RunScope::sides.
void note_sides(RunScope& scope, const std::vector<double>& from_mm,
                const std::vector<double>& to_mm);
Awaitable<Result<Arrival>> go_to(RunScope& scope, std::vector<double> q_mm, std::string cause,
                                 AxesToMove moved = {});

}  // namespace driftwise::application
