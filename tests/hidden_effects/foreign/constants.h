#pragma once

#include <numbers>

namespace driftwise::foreign {

inline constexpr double kTurn = 2.0 * std::numbers::pi;
// By definition.
inline constexpr double kRadPerArcsec = std::numbers::pi / (180.0 * 3600.0);

}  // namespace driftwise::foreign
