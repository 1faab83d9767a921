#pragma once
// What compensation achieved: target minus measured of every point of a run, per pose coordinate.
//
// The target of a point is its column "x_target_mm" (every run of a trajectory of poses has it), in
// any unit of the measurement's kind; of a run of motor coordinates with one axis it is what was
// commanded, "q1_cmd_mm" for "x_mm". Poses
// count from the run's own zero, as the instruments do. Returns to zero are left out: they are
// where the zero was taken. Rows that a person keeps out are left out.

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/calibration/model/model.h"
#include "server/core/data/accuracy.h"
#include "server/core/data/dataset.h"
#include "server/core/result.h"

namespace driftwise::diagnosis {

struct RunToVerify {
  RunId run;
  bool compensated = false;
  std::optional<ModelId> with;                      // whose targets were moved to
  std::shared_ptr<const calibration::Model> model;  // that one; null: not known
  Dataset data;                                     // of this run alone, as exported
};

struct VerifiedCoordinate {           // of one run; unit: summary unit
  Channel channel;                    // x_mm
  std::string unit;                   // "nm"
  std::vector<double> errors;         // target minus measured, one per row; NaN: not judged
  ErrorFigures all, inside, outside;  // of the model's range
  // Without what the axes missed of their own targets: the model's share of the error. None: the
  // run is not compensated, or its model has another number of axes than the pose.
  std::optional<ErrorFigures> by_model;
  double largest = 0;
  std::size_t largest_row = 0;  // of the dataset, from 0
};

struct VerifiedRun {
  RunId run;
  bool compensated = false;
  std::optional<ModelId> with;
  std::int64_t rows = 0, rows_outside = 0, rows_zero = 0;
  std::vector<std::string> outside;  // "t05_degC above 23.1": what left the model's range
  std::vector<VerifiedCoordinate> coordinates;
};

// Two runs on the positions that both visited, coordinate by coordinate.
struct VerifiedChange {
  RunId run, against;
  std::int64_t positions = 0;  // visited by both; 0: none, then figures are of all rows of each
  std::vector<JudgedAccuracy> coordinates;  // output: "x"; before: of `against`
};

struct Verification {
  std::vector<VerifiedRun> runs;        // in the order asked for
  std::vector<VerifiedChange> changes;  // of the first run against every other
  std::vector<JudgedAccuracy> heading;  // per unit, the first run's worst coordinate; before: of
                                        // the second run on the same positions
};

// range: whose range says inside and outside; null: each run's own model, else that of the first
// run that has one. Errors: invalid_argument NO_TARGETS (a run without wanted poses),
// UNKNOWN_CHANNEL (none of its coordinates was measured), UNITS_DISAGREE (target and measurement,
// or with a model's, cannot be converted), TOO_FEW_ROWS (fewer than 2 points but returns to zero).
Result<Verification> verify_runs(std::span<const RunToVerify> runs,
                                 const calibration::Model* range);

}  // namespace driftwise::diagnosis
