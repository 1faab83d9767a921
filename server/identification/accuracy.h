#pragma once
// The same accuracy figures for every method, on the same rows.

#include <optional>
#include <string>
#include <vector>

#include "server/calibration/report/held_out.h"
#include "server/identification/method.h"

namespace driftwise::identification {

struct JudgeOptions {
  int blocks = 10;         // contiguous blocks of time held out in turn; below 2: not done
  double gap = 0.25;       // of a block's rows, left out of the training on either side of it
  std::string together{};  // rows that are held out together: "line" or channels; "": not done
  int folds = 10;          // of whole groups
};

struct OutputFigures {  // column unit; figures of server/core/data/accuracy.h
  Channel channel;
  int parameters = 0;
  double rms = 0;  // of the calibration residuals
  double u90_calibration = 0, mean_calibration = 0, a90_calibration = 0;
  std::optional<double> u90_validation, mean_validation, a90_validation;
  std::optional<calibration::HeldOut> blocks, groups;
  std::optional<double> pure_error;  // standard deviation of a residual about its group's mean
};

// What is left of a position, the length of the vector over all outputs: for outputs of one unit.
struct PositionFigures {
  std::string unit;
  double rms = 0;  // sqrt(mean |e|^2) over the calibration rows, as is usual for robots
  std::optional<double> rms_validation, rms_blocks, rms_groups, pure_error;
};

struct Judgement {
  FittedMethod fitted;
  std::vector<OutputFigures> outputs;
  std::optional<PositionFigures> position;  // with two outputs and more
  std::int64_t rows_calibration = 0, rows_validation = 0, groups = 0;
  std::vector<std::string> warnings;
};

// Fits the method on the calibration rows, then again without each fold; every decision that looks
// at data (placement, selection, which parameters can be told apart) is repeated inside the
// training part. Rows in which a channel that formula or mechanism
// reads has no value are left out for every method alike. Rows of a datum outside the training are
// judged about their mean. Errors: those of fit_method; UNKNOWN_CHANNEL, NO_LINES (together).
Result<Judgement> judge_method(const Dataset& dataset, Method method, const MethodOptions& options,
                               const JudgeOptions& judge);

}  // namespace driftwise::identification
