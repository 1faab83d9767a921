#pragma once
// A model of known coefficients for the tests of targets: q1 = x + 0.001 (t05 - 20), in mm.

#include "tests/integration/cell/cell_at_work.h"

namespace driftwise::tests {

inline constexpr double kServedMmPerKelvin = 0.001;
inline constexpr double kServedLimit_mm = 4;  // the domain in x

// Imports the data of such a robot, fits it, and lets the model serve; its number. Noise of a
// nanometre, so that there is a residual to speak of.
std::int64_t serve_known_model(const CellAtWork& cell);

}  // namespace driftwise::tests
