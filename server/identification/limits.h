#pragma once
// What limits a model, in words: the noise of instruments and axes, lack of fit, temperatures that
// the calibration did not cover, drift; and what limits a target. From figures that a fit and a
// budget have.

#include <optional>
#include <string>
#include <vector>

#include "server/calibration/model/model.h"
#include "server/core/data/dataset.h"

namespace driftwise::identification {

struct LimitFacts {  // of one output, all in its summary unit (nm, arcsec)
  std::string unit;
  double a90_calibration = 0;
  std::optional<double> a90_blocks, a90_validation;
  std::optional<double> pure_error;  // standard deviation of a repeat
  std::optional<double> lack_of_fit_p;
  double slow_share = 0, slow_rows = 0;  // of the residuals' variance
  std::vector<std::string> uncovered{};  // "t07 0.8 K above": validation rows beyond the fit's
};

struct Limit {
  std::string cause;  // "noise", "lack_of_fit", "temperatures", "drift", "rows", "unknown", of a
                      // target "instrument": for programs
  std::string words;  // "noise of instruments and axes: repeats of a pose scatter by 4.1 nm ..."
};

// The largest part of A90, which is what differs from row to row. The first that applies:
// validation rows beyond the temperatures of the fit and half as bad again as the blocks of time;
// repeats that make up half of the variance; residuals of which half the variance is slow, over ten
// rows and more; repeats that leave a lack of fit; held-out blocks half as bad again as the fit's
// own rows. An error that all rows share is none of these: target_limited_by().
Limit limited_by(const LimitFacts& facts);

struct TargetLimitFacts {  // of one output at one pose
  std::string unit;
  double u90 = 0;  // 1.645 times the combined standard uncertainty
  // Of the largest budget line that an instrument declares, and 1.645 times that line.
  std::string instrument{};
  double instrument_u90 = 0;
};

// The instrument whose line makes up half of the variance that a target states; none: no one does.
std::optional<Limit> target_limited_by(const TargetLimitFacts& facts);

// Of a fitted model and the rows that it was fitted to and judged on.
LimitFacts limit_facts(const Dataset& dataset, const calibration::Model& model,
                       const calibration::OutputModel& output);

}  // namespace driftwise::identification
