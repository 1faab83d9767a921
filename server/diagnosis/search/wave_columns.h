#pragma once
// The columns of a periodic cause's whole grid at once. Where its periods are uniform in 1/period
// each wave is the one before it turned by one and the same angle: one multiplication per row
// instead of a sine. The rounding of thousands of turns stays below 1e-12; what is found is
// evaluated once more by the effects themselves.

#include <Eigen/Core>
#include <functional>
#include <optional>

#include "server/diagnosis/catalogue/cause.h"
#include "server/diagnosis/rows/problem.h"

namespace driftwise::diagnosis {

// One row per block, sine and cosine of each cell in turn. Nothing for a cause that is not a wave,
// where values are missing, and when tick says stop.
std::optional<Eigen::MatrixXd> wave_columns(const Problem& problem, const Cause& cause,
                                            const std::function<bool()>& tick);

}  // namespace driftwise::diagnosis
