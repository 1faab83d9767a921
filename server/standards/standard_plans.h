#pragma once
// The trajectories that a standard's figures need: who runs one has what iso230_2, iso230_3 or
// iso9283 ask for.

#include <cstdint>
#include <vector>

#include "server/core/trajectory/trajectory.h"

namespace driftwise::standards {

// Another coordinate's place all through the test.
struct Held {
  Channel channel;
  double at_mm = 0;
};

struct Iso2302Plan {
  Channel axis{"q1", "mm"};
  double from_mm = 0, to_mm = 0;
  int positions = 9;
  int approaches = 5;
  double overrun_mm = 0;  // beyond the ends, where the axis turns round; 0: a quarter of the step
  double scatter = 0.25;  // positions lie unevenly, by up to this share of the step to either side
                          // (inwards at the ends), so that a periodic error is not met at one phase
  std::uint32_t seed = 1;  // of the scatter
  std::vector<Held> held = {};
};
// From beyond the lower end up through all positions, from beyond the upper end down through all;
// `approaches` times. One line per pass, which begins with its overrun, so that a return to zero
// between two lines changes no side; first and last a return to zero.
// Errors: invalid_argument BAD_PLAN saying what.
Result<Trajectory> iso230_2_plan(const Iso2302Plan& plan);

struct Iso2303Plan {
  Channel axis{"q1", "mm"};
  std::vector<double> at_mm;  // one: the axis rests there; more: visited in turn, from below
  double hours = 4, every_s = 300;
  double overrun_mm = 0.1;  // below the lowest, so that each is approached from below
  std::vector<Held> held = {};
};
// Rows dwell so that a round takes every_s besides its moves and readings. One line per round,
// which begins below the lowest position; at rest one line, without a return to zero in it.
Result<Trajectory> iso230_3_plan(const Iso2303Plan& plan);

struct Iso9283Plan {
  std::vector<Channel> axes;      // one to three
  std::vector<double> centre_mm;  // of the cube, by axis
  double edge_mm = 0;
  int cycles = 30;
  std::vector<Held> held = {};
};
// P1 in the middle, P2 to P5 on the diagonals of the plane through two opposite edges of the cube
// (one in x and y up, one in x and y down), at a tenth of the diagonal from its ends; P1 .. P5 in
// turn and in one line, so that each pose is always approached from the same one. With two axes the
// corners of the square, with one five places on the line.
Result<Trajectory> iso9283_plan(const Iso9283Plan& plan);

}  // namespace driftwise::standards
