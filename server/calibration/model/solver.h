#pragma once
// How the rows of a fit become a triangle: see row_reduction.h.

#include <cstdint>
#include <string_view>

namespace driftwise::calibration {

enum class Solver : std::uint8_t {
  automatic,  // gram where the rows are many and it is safe, else qr
  qr,
  gram,  // asked for: tried on any number of rows, left for qr where it is not safe
};
constexpr std::string_view to_string(Solver solver) {
  return solver == Solver::gram ? "gram" : solver == Solver::qr ? "qr" : "automatic";
}

}  // namespace driftwise::calibration
