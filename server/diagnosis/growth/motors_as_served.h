#pragma once
// What a simulation in the frame of the coordinates leaves of the motors behind them, as it is
// served: of each motor with the findings that are said of it and no others. What is judged and
// what is printed of a motor is this.

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "server/diagnosis/growth/extension.h"
#include "server/diagnosis/noise/soft_base.h"
#include "server/diagnosis/search/coordinate_frame.h"

namespace driftwise::diagnosis {

// What a simulation leaves of one coordinate, of some rows.
using LeftOfCoordinate =
    std::function<Eigen::VectorXd(const ProblemOutput& coordinate, const SoftBase& simulation)>;

// rows: those that `left` is of. without: leaves one of the named out. Rows x motors, summary
// units.
Eigen::MatrixXd motors_as_served(const CoordinateFrame& frame, const Problem& problem,
                                 const Extension& extension, const std::vector<std::size_t>& rows,
                                 const LeftOfCoordinate& left,
                                 std::optional<std::size_t> without = {});

// The same of the rows that judge.
Eigen::MatrixXd judged_motors_as_served(const CoordinateFrame& frame, const Problem& problem,
                                        const Extension& extension,
                                        std::optional<std::size_t> without = {});

// By the baseline alone, of the rows that judge.
Eigen::MatrixXd judged_motors_by_baseline(const CoordinateFrame& frame, const Problem& problem);

}  // namespace driftwise::diagnosis
