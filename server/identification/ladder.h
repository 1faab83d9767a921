#pragma once
// The ladder of terms: a model grows from the constant by groups of terms (orders of the geometry,
// temperatures, force, products of both with the pose), each time by the group that predicts rows
// best which it has not seen, until none does.

#include <optional>
#include <string>
#include <vector>

#include "server/calibration/fit.h"

namespace driftwise::identification {

struct Rung {
  std::string name;     // "geometry of order 2", "temperatures", "force x position"
  std::string formula;  // what it adds, as a formula writes it: "poly(x, y, z, 2)"
  std::vector<effects::Term> terms;
  std::vector<std::string> needs;  // rungs that must be in before; empty: none
};

// The rungs that the channels of the dataset allow, the lowest first: position of order 1 to
// most_order, temperatures (those on the robot where the dataset says so, else all), force up to
// the third power, products of both with the position up to the second order. A channel that does
// not vary over the calibration rows (by 1 nm, 1 arcsec, 0.01 K, whatever its unit) gives none.
// Outputs are not among the terms.
std::vector<Rung> rungs_of(const Dataset& dataset, const std::vector<std::string>& outputs,
                           int most_order = 5);

struct LadderOptions {
  calibration::FitOptions fit;  // selection, executor; candidates.outputs: what is predicted
  std::string together{};       // rows held out together: "line" or channels; "": blocks of time
  int folds = 10;
  double gap = 0.25;  // of blocks of time, as identification::time_folds
  int most_order = 5;
  double least_gain = 0.01;  // of A90; less is no gain whatever its uncertainty
};

struct LadderFigure {  // of one output, column unit, rows held out
  Channel output;
  double a90 = 0, low = 0, high = 0;     // 90 % interval
  std::optional<double> a90_validation;  // reported, never asked
};

struct LadderStep {
  std::string added;    // name of the rung; "the constant" for the first
  std::string formula;  // of everything in
  int terms = 0;  // of the fit on all calibration rows, mean over the outputs, constant counted
  std::vector<LadderFigure> outputs;
  double a90_rms = 0;  // root mean square over the outputs
  double gain = 0;     // share of the step before: 1 - a90_rms / before
  double gain_u = 0;   // standard uncertainty of it, paired by fold
};

struct LadderTrial {  // what was tried at the end, and did not help enough
  std::string name;
  double a90_rms = 0, gain = 0, gain_u = 0;
  std::string why_not;  // the fit's reason where it could not be fitted; else empty
};

struct Ladder {
  std::vector<LadderStep> steps;
  std::vector<LadderTrial> refused;  // at the last step
  std::string stopped;               // sentence: why it stopped
  std::string held_out;              // "10 blocks of time", "10 folds of whole lines"
  std::int64_t rows = 0;             // calibration rows
  std::vector<std::string> notes;    // sentences: channels that do not vary
  const std::string& formula() const { return steps.back().formula; }
};

// A rung is taken when it lowers the held-out A90 (root mean square over the outputs, of which all
// must be of one unit) by more than least_gain and by more than the gain's own standard
// uncertainty; of those that gain as much as
// the best within its uncertainty the one that offers the fewest terms. Rows marked validation are
// not asked. Errors: invalid_argument NO_OUTPUT, UNITS_DISAGREE, NO_BLOCKS (too few rows or groups
// for the folds); those of fit().
Result<Ladder> climb(const Dataset& dataset, const LadderOptions& options);

}  // namespace driftwise::identification
