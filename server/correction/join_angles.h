#pragma once
// Errors of autocollimators that the returns to zero of one session do not show, estimated from a
// rotation that two sessions measured.
//
// Drift. Both readings of the common rotation have their returns to zero, in the same rows of the
// trajectory: the mean square of the mean of the two is what drift does to the joined rotation,
// with the part in which two slow drifts agree, which the difference of the two sessions cannot
// show.
//
// Roll and scale. A roll about its beam by rho and an error s of its scale let one autocollimator
// read (1 + s) (a + rho b) and (1 + s) (b - rho a) of two rotations a and b. At pose zero both are
// zero. Two sessions that read a common rotation j, the first with k, the second with i, differ by
//   d = rho_1 k - rho_2 i + (s_1 - s_2) j + constant + noise
// once the lines between their returns to zero are taken off (drift goes with the grid's slow
// motor, as the rotations do). Ordinary least squares over the common rows gives both rolls, and of
// the scales the difference. The error of a rotation that one session alone measured follows from
// the roll that was found there, and from s_1 - s_2 as two errors of one size (its square over 2).
// Of each the square less that of its own standard uncertainty counts: what the rows show.
// Nothing is corrected: the error counts in the stated uncertainty (JCGM 100:2008, F.2.4.5).
//
// Rotations in arcsec, rolls in rad. Pure; one thread. Assumption: the two rotations of one
// session come from one autocollimator.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "server/correction/join_part.h"
#include "server/correction/join_suspicion.h"

namespace driftwise::correction {

struct RollEstimate {
  std::string part;  // name
  double rad = 0, u_rad = 0;
};

struct AngleErrors {
  // Mean square over the rows, arcsec^2, of rx, ry, rz. Measured once: to be added to the variance
  // by the returns. Measured twice: the variance of the mean. Empty: the rows say nothing of it.
  std::array<std::optional<double>, 3> square;
  std::vector<RollEstimate> rolls;  // sign: of the second angle in the reading of the common one
};

// Of the parts as aligned at their zeros. Empty where no rotation was measured in two parts;
// without rolls where the rows have no time, or do not separate the rotations.
AngleErrors angle_errors(const JoinParts& parts, const MatchedRows& rows, const JoinRules& rules);

}  // namespace driftwise::correction
