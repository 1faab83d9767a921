#pragma once
// A trajectory run on a simulated robot in process, without a wire: what a cell would export, and
// what was hidden, by the plant's own truth.

#include <cstdint>
#include <string>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/core/trajectory/trajectory.h"

namespace driftwise::hidden {

struct PlantRun {
  Dataset data;
  // Per mechanism hidden, in the order of the plant file: its share of every row, nm. Those that
  // have no length of their own (air, thermometers, a beam's place) are not in it.
  std::vector<std::vector<double>> hidden_nm;
  // Per pose axis: where the end-effector was at every row since the lengths were zeroed, in the
  // robot's own frame. What a target is judged by.
  std::vector<std::vector<double>> true_mm;
  std::vector<double> zero_q_mm;  // motor coordinates where the lengths were zeroed
};

struct PlantStart {
  std::uint64_t seed = 1;
  std::vector<std::string> overrides{};  // of the plant file
};

// The linear axis: q1_mm, x_mm, t01..t10, air, pressure (as a barometer beside it would give it),
// dwell. A point's dwell comes after 1 s of settling; four readings of half a second. Several
// trajectories follow one another on the same plant without a pause, as runs 1, 2, ..
PlantRun run_on_axis(const PlantStart& start, const std::vector<Trajectory>& trajectories);

// The Micro-Nano, with coarse steps: q1..q3, pose, rotations, force, t01..t10.
PlantRun run_on_micro_nano(const PlantStart& start, const std::vector<Trajectory>& trajectories);

// The published plans as trajectories, with the dwell that gives their time per point.
Trajectory published_axis_plan(int passes);
Trajectory published_micro_nano_plan();
// 17 places in random order with dwells of 0, 3, 10, 30 and 100 s; every third is for validation.
Trajectory varied_axis_plan(int points, std::uint64_t seed);
// Multiples of an irrational number over `length_mm`, back and forth over the middle.
Trajectory fine_axis_plan(int points, double length_mm);

}  // namespace driftwise::hidden
