#pragma once
// The error of a model at the points of a run that it was not fitted to.
//
// The model is inverse: q = f(pose, temperatures, force). The error of a point is what the scales
// read back minus f(measured pose, ...): the commanded coordinates, and with them the axis' holding
// error, play no part. In a datum of its own a run is compared as a model serves there
// (docs/decisions/0005): error = (q - q at the zero) - (f(now) - f(0, at the zero)).

#include <string>
#include <vector>

#include "server/calibration/model.h"
#include "server/core/dataset.h"
#include "server/core/result.h"

namespace driftwise::diagnosis {

struct RunToCheck {
  RunId run;
  Dataset data;  // of this run alone
  // Per datum of the data, in order of appearance: what the datum's record holds (q where the zero
  // lies, the temperatures at that instant). Empty or incomplete: the datum has no known zero.
  std::vector<std::vector<ChannelValue>> zeros;
};

struct RunErrors {                 // of one output, in its summary unit (nm)
  std::vector<double> values;      // one per row; NaN: excluded, or a channel is missing
  std::int64_t rows = 0;           // that have a value
  bool anchored = true;            // false: a datum without a known zero, judged about its mean
  double model_variance = 0;       // mean over the rows of the model's own variance there ...
  double model_mean_variance = 0;  // ... and the variance of its mean, common to every run
};

// Errors: invalid_argument UNKNOWN_CHANNEL (the run lacks one that the model reads), UNTIMED.
Result<RunErrors> run_errors(const calibration::OutputModel& output, std::int64_t calibration_rows,
                             const RunToCheck& run);

}  // namespace driftwise::diagnosis
