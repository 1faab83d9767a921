#pragma once
// The pose as the motor coordinates and the conditions predict it. A column of the *measured* pose
// contains the noise of the output that the pose is measured for: with every row its own place, a
// wave of the grid's period through the measured coordinate explains all rows of data with nothing
// in them (NUMERICS.md section 4). Columns of causes are computed from the prediction.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/core/result.h"

namespace driftwise::diagnosis {

// Which of the two readings of a position repeats itself exactly, so that it has no noise of its
// own: a plan that was computed, not measured.
bool repeats_exactly(const std::vector<double>& values);
// The same within each datum that has enough rows: rows of further datums are moved to the first
// one's frame, and a plan that was computed then repeats within a datum only.
bool repeats_exactly(const Dataset& dataset, const std::vector<double>& values);

// Is a coordinate on a lattice the reading of a display in fine steps, and no plan? It takes few of
// the lattice's sites, and values follow one another within the noise: no plan sends a machine to
// two places that the machine cannot tell apart. noise: standard deviation of the reading, in its
// unit.
bool is_read_in_steps(const std::vector<double>& values, double noise);
// The same within a datum, as above.
bool is_read_in_steps(const Dataset& dataset, const std::vector<double>& values, double noise);

// Number of different places of these coordinates, one value per row each. Rows that lack a value
// do not count.
std::size_t different_places(const std::vector<const std::vector<double>*>& coordinates);

// A pose coordinate from the motors by a polynomial and, linearly, the temperatures, forces, air
// and time of the row, fitted to all rows. Nothing where no motor varies or too few rows are
// complete. Missing motors leave the measured value.
std::optional<std::vector<double>> predicted_coordinate(const Dataset& dataset,
                                                        const std::string& symbol);

struct Problem;

// The pose at which the baseline, fitted at the measured pose, has each row's motor coordinates:
// Newton's method from the prediction above, one solution for each row. A polynomial of third
// degree is micrometres off the inverse of another one, which is a whole period of a laser's wave.
// Taken where one of its coordinates lies nearer to the measured one by a hundredth and none
// farther. Nothing where the baseline has not as many motors as it
// reads coordinates, or one: its fifth degree is near enough.
// at_measured: the baseline's columns there. Errors: those of Prepared::columns.
Result<void> solve_for_pose(Problem& problem, const Eigen::MatrixXd& at_measured);

}  // namespace driftwise::diagnosis
