#pragma once
// The linear axis of case A as a cell sees it, judged by its plant's truth.

#include <cstdint>
#include <memory>
#include <string>

#include "drivers/simulated/plant/linear_axis/linear_axis_plant.h"
#include "tests/statistics/served_case.h"

namespace driftwise::statistics {

// The published campaign of a machine and a room drawn with this seed, within the ranges that the
// plant's file states; its 448 validation poses are the targets, each at its own time. The truth is
// where the end-effector was since the interferometer's zero, in the robot's own frame
// (drivers/simulated/plant/truth.h).
SimulatedCase linear_axis_case(std::uint64_t seed);

// The same with the machine, so that time can go on. schedule: of the room's set-point, "[[hours,
// degC], ..]"; empty: drawn with the machine.
struct LinearAxisMachine {
  std::unique_ptr<simulated::LinearAxisPlant> plant;
  SimulatedCase measured;
};
LinearAxisMachine linear_axis_machine(std::uint64_t seed, const std::string& schedule);

// Name of the thermometer at this place, from 0: "t01".
std::string axis_sensor(std::size_t i);

}  // namespace driftwise::statistics
