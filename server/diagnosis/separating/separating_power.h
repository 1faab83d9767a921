#pragma once
// How well a plan would tell hypotheses apart: all are run forward over it, and what they differ
// by, beyond what the simulation could take up, is held against the noise.

#include <cstdint>
#include <vector>

#include "server/calibration/fit.h"
#include "server/core/data/dataset.h"
#include "server/core/result.h"
#include "server/diagnosis/separating/hypothesis.h"

namespace driftwise::diagnosis {

// Two hypotheses whose predictions lie no further apart than this stay together (DESIGN.md's
// statistical contract).
inline constexpr double kIdentifiable2lnl = 20;

struct SeparatingPower {
  // Per hypothesis, from 0: the class that it stays in under this plan. Hypotheses are of one class
  // when they are closer than kIdentifiable2lnl, or linked by others that are.
  std::vector<std::size_t> class_of{};
  std::size_t classes = 0;
  // Between the truth and the nearest of another class, the hardest pair; where all are of one
  // class, the widest pair.
  double expected_2lnl = 0;
  double power = 0;  // that the truth's class is ahead by more than kAhead2lnl, the hardest truth
};

// A rival further behind than this is not reported (NUMERICS.md section 3, point 6).
inline constexpr double kAhead2lnl = 6;

// rows: the planned ones. base: the simulation's terms; their coefficients are free again, as they
// are in a new run. simulations: of the noise, per truth; 0: expected_2lnl only.
// Errors: those of the effects.
Result<SeparatingPower> separating_power(const Dataset& rows,
                                         const std::vector<effects::Term>& base,
                                         const std::vector<Hypothesis>& hypotheses,
                                         const std::vector<OutputSummary>& outputs, int simulations,
                                         std::uint64_t seed);

}  // namespace driftwise::diagnosis
