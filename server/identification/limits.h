#pragma once
// What limits a model, in words: the noise of instruments and axes, lack of fit, temperatures that
// the calibration did not cover, drift, an instrument. From figures that a fit and a budget have.

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
  std::string instrument{};              // of the largest budget line that is an instrument's
  std::optional<double> instrument_a90;  // 1.645 times that line's standard uncertainty
};

struct Limit {
  std::string cause;  // "noise", "lack_of_fit", "temperatures", "drift", "instrument", "rows",
                      // "unknown": for programs
  std::string words;  // "noise of instruments and axes: repeats of a pose scatter by 4.1 nm ..."
};

// The first that applies: validation rows beyond the temperatures of the fit and half as bad again
// as the blocks of time; an instrument that makes up 0.7 of the accuracy; repeats that make up 0.8;
// residuals of which half the variance is slow, over ten rows and more; repeats that leave a lack
// of fit; held-out blocks half as bad again as the fit's own rows.
Limit limited_by(const LimitFacts& facts);

// Of a fitted model and the rows that it was fitted to and judged on.
LimitFacts limit_facts(const Dataset& dataset, const calibration::Model& model,
                       const calibration::OutputModel& output);

}  // namespace driftwise::identification
