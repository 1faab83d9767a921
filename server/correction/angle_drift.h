#pragma once
// Drift of one rotation's reading with a temperature: the 45 degree mirror over which an
// autocollimator looks turns with its mount, and the robot does not. Pure.

#include <string>

#include "server/core/data/dataset.h"
#include "server/core/result.h"
#include "server/correction/data_amendment.h"

namespace driftwise::correction {

struct AngleDrift {
  double arcsec_per_k = 0, u_arcsec_per_k = 0;  // of what is read; standard uncertainty
  std::size_t returns = 0, datums = 0;          // that it comes from; 0: it was stated
  double span_k = 0;                            // of the temperature over them, the widest datum's
  double residual_arcsec = 0;                   // standard deviation of the returns about it
};

// At a return to zero the robot's rotation is where it was: what the reading changes by is drift.
// Least squares over all returns with an intercept per datum. Noise is taken as independent between
// returns; u comes from the residuals. A robot whose own zero turns with the same temperature is
// not told from it.
//
// Errors, invalid_argument: UNKNOWN_CHANNEL, no such rotation or thermometer; NO_POSE_ZERO, no
// column zero or too few returns (3 more than datums); BAD_RANGE, the temperature changes by less
// than 20 mK in every datum.
Result<AngleDrift> drift_from_returns(const Dataset& dataset, const std::string& axis,
                                      const std::string& thermometer);

// The drift as an amendment of these runs; no runs: of all. source: where it comes from.
AngleShift shift_from(const AngleDrift& drift, const std::string& axis,
                      const std::string& thermometer, std::string source,
                      std::vector<RunId> runs = {});

}  // namespace driftwise::correction
