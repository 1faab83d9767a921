#pragma once
// A grid to measure: calibration positions, validation positions in the middles of its cells,
// returns to zero, forces, repeats. Pure: the same plan gives the same points, always.

#include <cstdint>
#include <optional>
#include <vector>

#include "server/core/result.h"
#include "server/core/trajectory/trajectory.h"

namespace driftwise {

struct GeneratorAxis {
  Channel coordinate;  // q1_mm, or x_mm
  double from_mm = 0, to_mm = 0;
  std::int64_t count = 1;  // of calibration positions, both ends included
};

struct GeneratorPlan {
  std::vector<GeneratorAxis> axes;  // the first one moves fastest
  std::int64_t line_length =
      0;  // points between two returns to zero; 0: one line of the first axis
  bool with_validation = false;
  std::vector<double> forces_n;  // the whole grid under each, in this order; empty: no force
  std::int64_t repeats = 1;
  bool both_directions = false;  // every second pass backwards
  // Positions in a random order that this seed repeats. With several forces each pass is measured
  // in two halves, the second ones with the forces in reverse: f1 f2 f3 f3 f2 f1.
  std::optional<std::uint64_t> shuffle_seed;
};

constexpr std::int64_t kMostGeneratedRows = 200'000;

// Each line ends with a return to zero. Validation positions come interleaved: after each line of
// the calibration grid those of the cells beside it, unless the order is shuffled. Errors:
// invalid_argument BAD_PLAN naming the field; resource_exhausted TOO_MANY_ROWS.
Result<Trajectory> generate_trajectory(const GeneratorPlan& plan);

}  // namespace driftwise
