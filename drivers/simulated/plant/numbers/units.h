#pragma once

#include <numbers>

namespace driftwise::simulated {

inline constexpr double kNmPerMm = 1e6;
inline constexpr double kRadPerArcsec = std::numbers::pi / (180.0 * 3600.0);  // by definition

}  // namespace driftwise::simulated
