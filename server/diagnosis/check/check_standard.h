#pragma once
// Does the robot still do what the model says? Every run after the model was made is a check
// standard: the model's error at its points, on control charts whose limits come from the model's
// own held-out accuracy.
//
// Charts and limits, per output (source: NIST/SEMATECH e-Handbook of Statistical Methods):
//   bias    mean error of a run, Shewhart (2.2.2.1, 6.3.2): +- t(0.99865, reference dof) u, the
//           t value that leaves as much outside as 3 sigma do. u^2 = s^2 / n_eff of the run + s^2
//           of its zero reading + the model's own variance of that mean;
//   spread  standard deviation of a run's errors (2.2.3.1): below s k sqrt(F(0.99865; dof of the
//           run, reference dof)), k^2 = 1 + the model's variance among the points / s^2;
//   both again as EWMA with lambda 0.2 and 3 sigma limits (6.3.2.4), from the second run on, for
//           what a single run does not show. What all runs share (the model's coefficients, the
//           reference) does not average out, and the limits say so.
// s, the reference: held-out A90 by blocks of time / 1.645, its dof from the interval over the
// blocks; without blocks the validation rows, without those the residuals. n_eff and the dof of a
// run: rows thinned by the model's own lag-1 autocorrelation r: n (1 - r)/(1 + r) for a mean
// (Bayley and Hammersley 1946), n (1 - r^2)/(1 + r^2) for a variance (Bartlett 1946).

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/diagnosis/check/check_errors.h"

namespace driftwise::diagnosis {

struct CheckReference {  // of one output, summary unit
  double sd = 0, dof = 0, lag1_autocorrelation = 0;
  std::string source;  // "blocks of time", "validation rows", "residuals"
};

struct CheckPoint {  // one run on the charts of one output; summary unit
  RunId run;
  std::int64_t rows = 0, excluded = 0;
  double effective_rows = 0;
  bool judged = false;
  std::string why_not;  // when it is not
  double bias = 0, sd = 0, u90 = 0, a90 = 0;
  std::optional<double> bias_limit;  // none: the run's zero is not known, its mean says nothing
  double sd_limit = 0;
  std::optional<double> ewma_bias, ewma_bias_limit;      // from the second judged run on
  std::optional<double> ewma_spread, ewma_spread_limit;  // of ln(variance / expected), one-sided
  std::vector<std::string> out_of_control;               // sentences; empty: in control
};

struct OutputCheck {
  Channel channel;
  std::string unit;  // summary unit
  CheckReference reference;
  std::vector<CheckPoint> points;  // one per run, in their order
};

enum class CheckVerdict { not_judged, in_control, recalibrate };

struct CheckReport {
  CheckVerdict verdict = CheckVerdict::not_judged;  // by the last run that could be judged
  std::vector<std::string> reasons;                 // of recalibrate: sentences
  std::vector<OutputCheck> outputs;
};

// runs: in order of time. One that lacks a channel, or has too few rows, is not judged and says so.
// Rows at which an effect with memory is not known (check_memory.h) are not judged, and a zero at
// which it is not counts as none.
CheckReport check_model(const calibration::Model& model, std::span<const RunToCheck> runs);

}  // namespace driftwise::diagnosis
