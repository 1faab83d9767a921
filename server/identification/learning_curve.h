#pragma once
// How many points buy how much accuracy: held-out A90 of a formula fitted to some of the rows,
// chosen at random or so that they fill the space.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/calibration/fit.h"

namespace driftwise::identification {

struct CurveOptions {
  calibration::FitOptions fit;  // with its candidates
  std::string together{};       // rows held out together; "": blocks of time
  int folds = 10;
  double gap = 0.25;
  int sizes = 8;           // numbers of rows, geometric from twice the offered terms to all
  int draws = 5;           // random subsets of a size, per fold
  std::uint64_t seed = 1;  // of the draws
};

struct CurveFigure {                  // root mean square over the outputs, column unit
  double a90 = 0, low = 0, high = 0;  // 90 % interval: jackknife over the folds
};

struct CurvePoint {
  std::int64_t rows = 0;                      // calibration rows used
  std::optional<CurveFigure> random, spread;  // none: could not be fitted with so few
};

struct LearningCurve {
  std::vector<CurvePoint> points;  // rising; the last has all rows that a fold leaves
  std::string unit;                // of the outputs: "mm"
  std::string held_out;
  std::int64_t rows = 0, terms = 0;  // calibration rows; terms offered, the constant counted
  // The fewest rows whose space-filling figure is within 5 % of that of all rows.
  std::int64_t enough = 0;
  // Share by which A90 would still fall with twice the rows: from the slope of the curve's end in
  // the logarithm of the rows, not below 0.
  double gain_of_doubling = 0;
};

// Space-filling rows: the first nearest the mean, then always the row farthest from those chosen,
// over the channels that the terms read, each by its range (Kennard and Stone, Technometrics 11
// (1969) 137). Held-out rows are never among the chosen. Errors: invalid_argument NO_OUTPUT,
// UNITS_DISAGREE, NO_BLOCKS; those of fit() with all rows.
Result<LearningCurve> learning_curve(const Dataset& dataset, const CurveOptions& options);

// The first `count` rows in the order in which they would be chosen to fill the space of these
// symbols; of rows equally far the first. Time: count^2, and rows times count where the space has
// many dimensions; in few most rows are passed over.
std::vector<std::size_t> spread_order(const Dataset& dataset, const std::vector<std::size_t>& rows,
                                      const std::vector<std::string>& symbols, std::size_t count);

}  // namespace driftwise::identification
