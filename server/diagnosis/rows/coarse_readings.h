#pragma once
// A display that shows tenths of a degree hides up to 0.05 K of a part's temperature, and not at
// random: as long as the display stands still what is hidden grows with the part. A baseline with
// such a thermometer leaves a saw-tooth that lags, drifts and creep imitate.
//
// The course between the steps is estimated: a twice integrated Wiener process, of which each
// reading says within which step it was at that row. Its rate and the reading's own noise are the
// likeliest (Laplace's approximation of their marginal likelihood). What remains unknown of it is
// noise of known shape to whatever reads it (Problem::hidden).

#include <Eigen/Core>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "server/core/data/dataset.h"

namespace driftwise::diagnosis {

// The step of a reading that stands still in half of the rows and else changes by whole steps; 0:
// none, a step beyond `widest`, or fewer than 16 readings.
double display_step(const std::vector<double>& values, double widest);

inline constexpr double kWidestDisplay_K = 0.2;  // of a thermometer: what changes by more is set

struct Course {
  std::vector<double> values;
  // Its largest uncertainties, in the values' unit: values + unsure z is a likely course, z of
  // standard normal numbers. Rows x at most 24; 0 where a value is missing.
  Eigen::MatrixXd unsure;
};

// The likeliest course behind readings that are rounded to `step`; missing values stay missing.
// time_s: not decreasing, one per value.
Course between_steps(std::span<const double> time_s, const std::vector<double>& values,
                     double step);

struct CoarseChannel {
  double step = 0;
  Eigen::MatrixXd unsure;
};
// Puts the course in place of every coarse temperature and reading of the air; of these by symbol.
// In the catalogue's units.
std::map<std::string, CoarseChannel> estimate_between_steps(Dataset& data);

// "t01, t02 and 7 others are read in steps of 0.01 K: ..."; one per step, none of none.
std::vector<std::string> coarse_notes(const std::map<std::string, CoarseChannel>& coarse);

}  // namespace driftwise::diagnosis
