#pragma once
// Moves against the cell's [[keep_out]] rules. Pure.
//
// Axes move at once and arrive when they please, so a move is judged at the worst corner of the box
// between its two ends; a distance is linear in the axes, so no place inside the box is nearer.

#include <optional>
#include <string>
#include <vector>

#include "server/core/description/cell_description.h"
#include "server/core/result.h"

namespace driftwise::application {

// One entry per axis, all axes of the cell, in order; an axis that stays has the same in both. From
// a place that is too near already, only moves that bring the robots no nearer are allowed. Errors,
// out_of_range KEEP_OUT: robots, rule, distance asked for and found, where, what to do.
Result<void> check_keep_out(const CellDescription& cell, const std::vector<double>& from_mm,
                            const std::vector<double>& to_mm);

// The robot that may move first, and the others after it, where a move of all at once is refused;
// none: neither order keeps the distance. For moves from a place that no row names, such as where a
// stop halted the robots.
std::optional<std::string> first_to_move(const CellDescription& cell,
                                         const std::vector<double>& from_mm,
                                         const std::vector<double>& to_mm);

// Homing, judged as moves to the zeros, one controller after the other in the order of the devices.
// Errors: KEEP_OUT, naming the controller that would come too near.
Result<void> check_homing(const CellDescription& cell, std::vector<double> from_mm);

}  // namespace driftwise::application
