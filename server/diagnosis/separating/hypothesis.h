#pragma once
// What an indistinguishable set leaves open: each of its causes with the parameters that the data
// allow and the sizes that go with them, ready to be run forward over a plan.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "server/calibration/fit.h"
#include "server/core/data/dataset.h"
#include "server/core/result.h"
#include "server/diagnosis/answer/diagnosis.h"
#include "server/diagnosis/noise/noise_model.h"

namespace driftwise::diagnosis {

struct HypothesisCell {  // one value of the parameter
  std::vector<effects::Term> terms;
  Eigen::MatrixXd coefficients;  // terms x outputs, summary unit per unit of the term
  double below_2lnl = 0;         // how much worse than the best of its cause, on these data
};

struct Hypothesis {
  std::string cause, name;              // "backlash", "backlash q1"
  std::vector<HypothesisCell> cells{};  // the best first, then those within kOpen2lnl of it
};

// A parameter that loses no more than this may still be the true one (99.8 % of chi-squared with
// one degree of freedom).
inline constexpr double kOpen2lnl = 10;

NoiseShape noise_of(const OutputSummary& output);

// The causes of a finding's indistinguishable set, itself first, fitted beside the baseline and the
// other findings, each output under the noise that the diagnosis found.
// A periodic cause seen on a lattice of positions (or times) brings the shorter periods that look
// the same there as further hypotheses.
// Errors: those of lay_out() and of the effects.
Result<std::vector<Hypothesis>> open_hypotheses(const Dataset& dataset,
                                                const calibration::Candidates& baseline,
                                                const Diagnosis& diagnosis, std::size_t finding);

}  // namespace driftwise::diagnosis
