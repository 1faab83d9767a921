#pragma once

namespace driftwise::simulated {

inline constexpr double kNmPerMm = 1e6;

}  // namespace driftwise::simulated
