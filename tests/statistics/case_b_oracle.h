#pragma once
// The four models of case B, and one with cross terms, beside an oracle that knows the plant.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace driftwise::statistics {

struct CaseBModel {
  const char* name;
  const char* formula;
};
// G, G+F, G+T, G+T+F as published, and the last with what force and temperature do to the geometry.
const std::vector<CaseBModel>& case_b_models();

struct CaseBFigures {  // of one seed; U90 in nm on the validation grid inside the forces, by axis
  std::vector<std::array<double, 3>> models;  // in the order of case_b_models()
  std::array<double, 3> oracle{};
};

// The published campaign with this seed. The oracle knows the robot: what the scales must read for
// every true pose, and the Jacobian; it fits to the calibration rows only what the instruments add:
// offset, factors, drift and lever arms (1, x, y, z, time, rx, ry, rz).
CaseBFigures case_b_figures(std::uint64_t seed);

}  // namespace driftwise::statistics
