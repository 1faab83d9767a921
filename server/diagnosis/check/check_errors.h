#pragma once
// The error of a model at the points of a run that it was not fitted to.
//
// The model is inverse: q = f(pose, temperatures, force). The error of a point is what the scales
// read back minus f(measured pose, ...): the commanded coordinates, and with them the axis' holding
// error, play no part. In a datum of its own a run is compared as a model serves there
// (docs/decisions/0005): error = (q - q at the zero) - (f(pose + p0, now) - f(p0, at the zero)), p0
// being where that zero lies in the model's own datum.

#include <string>
#include <vector>

#include "server/calibration/model/model.h"
#include "server/core/data/dataset.h"
#include "server/core/result.h"

namespace driftwise::diagnosis {

struct ReadBefore {  // readings of one instant, in the time_s of the run's data
  double time_s = 0;
  std::vector<ChannelValue> values;
};

struct RunToCheck {
  RunId run;
  Dataset data;  // of this run alone
  // Per datum of the data, in order of appearance: what the datum's record holds (q where the zero
  // lies, the temperatures at that instant). Empty or incomplete: the datum has no known zero.
  std::vector<std::vector<ChannelValue>> zeros;
  // Per datum of the data: p0 of every axis by channel; poses of the data count from it. Empty: 0.
  // in_model_datum() fills it.
  std::vector<std::vector<ChannelValue>> zero_poses = {};
  // Of effects with memory (check_memory.h): when each zero was taken, in the data's time_s, and
  // what was read before the first row, oldest first. Empty: not known.
  std::vector<double> zero_times_s = {};
  std::vector<ReadBefore> before = {};
  std::string unknown_memory = {};  // a sentence; with_effects_as_channels() fills it
};

// The run, its zeros and what was read before it in the model's units. Errors: UNITS_DISAGREE.
Result<RunToCheck> in_model_units(const calibration::Model& model, RunToCheck run);

// The run's poses as the model has them: those of every datum from its p0. With a known zero p0 is
// what serving finds from it; without, where the model has the datum's rows on average. 0 where the
// model cannot tell (calibration/pose_of_zero.h).
RunToCheck in_model_datum(const calibration::Model& model, RunToCheck run);

struct RunErrors {                 // of one output, in its summary unit (nm)
  std::vector<double> values;      // one per row; NaN: excluded, or a channel is missing
  std::int64_t rows = 0;           // that have a value
  bool anchored = true;            // false: a datum without a known zero, judged about its mean
  double model_variance = 0;       // mean over the rows of the model's own variance there ...
  double model_mean_variance = 0;  // ... and the variance of its mean, common to every run
};

// run: as in_model_datum() gives it. Errors: invalid_argument UNKNOWN_CHANNEL (the run lacks one
// that the model reads), UNTIMED.
Result<RunErrors> run_errors(const calibration::OutputModel& output, std::int64_t calibration_rows,
                             const RunToCheck& run);

}  // namespace driftwise::diagnosis
