#pragma once
// The discrepancy: measured minus simulated, per output, and what it goes with. The first look of a
// diagnosis; it names no cause.
//
// In motor coordinates: what was read back minus what the model gives for the measured pose under
// the measured conditions.

#include <string>
#include <vector>

#include "server/calibration/model/model.h"
#include "server/core/data/dataset.h"
#include "server/core/result.h"

namespace driftwise::diagnosis {

struct Share {
  std::string variable;  // "x", "t07", "time"
  double share = 0;      // R^2 of the discrepancy on 1, v, v^2 alone: 0 .. 1
};

struct OutputDiscrepancy {
  Channel channel;
  std::string unit;                 // summary unit: "nm"
  std::vector<double> values;       // one per row; NaN where a channel is missing
  double mean = 0, u90 = 0;         // 1.645 sd, over the rows that have a value
  double lag1_autocorrelation = 0;  // between neighbouring rows
  std::vector<Share>
      explained_by;  // largest first, every channel that varies, and time where the rows have one
};

// R^2 of y on 1, v, v^2 over the rows where both are finite: 0 .. 1; 0 below 4 rows or without
// variation.
double marginal_share(const std::vector<double>& variable, const std::vector<double>& y);

// Rows of both sets. Errors: invalid_argument UNKNOWN_CHANNEL (the dataset lacks one the model
// reads), TOO_FEW_ROWS (fewer than 4 complete).
Result<std::vector<OutputDiscrepancy>> discrepancy(const calibration::Model& model,
                                                   const Dataset& dataset);

}  // namespace driftwise::diagnosis
