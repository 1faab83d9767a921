#pragma once
// The linear axis of case A as a cell sees it, judged by its plant's truth.

#include <cstdint>

#include "tests/statistics/served_case.h"

namespace driftwise::statistics {

// The published campaign of a machine and a room drawn with this seed, within the ranges that the
// plant's file states; its 448 validation poses are the targets, each at its own time. The truth is
// where the end-effector was since the interferometer's zero, in the robot's own frame
// (drivers/simulated/plant/truth.h).
SimulatedCase linear_axis_case(std::uint64_t seed);

}  // namespace driftwise::statistics
