#pragma once
// Readings that rest on one of two sides where no channel tells on which: dry friction holds the
// tip of a touching instrument up to half its width behind or ahead of what it touches, and the
// last micrometre of settling decides. What is left has then two levels, one width apart, shared by
// all outputs that the reading enters.
//
// Price of what is not known: a side for every row is one bit, 2 ln 2 in 2 ln L. Values that have
// no two sides cannot pay it: cut in two at their mean, normal values have 1 - 2 / pi of their
// variance left, which gives 1.01 a row.

#include <Eigen/Core>
#include <optional>

#include "server/diagnosis/noise/noise_model.h"
#include "server/diagnosis/noise/soft_base.h"

namespace driftwise::diagnosis {

// Distance of the sides over the standard deviation of the rows about them, at least. Cut in two at
// their mean normal values have 2.6, evenly spread ones 3.5 and those of a sine wave 4.1; what has
// no bound has less.
inline constexpr double kSidesApart = 5;

struct TwoSides {
  Eigen::VectorXd side;   // +1 or -1, one per row
  Eigen::VectorXd half;   // per output, unit of the series: what side +1 adds to it
  Eigen::VectorXd along;  // per output: the outputs' common part, on which the sides show best
  double apart = 0;       // as kSidesApart counts
  double gain = 0;      // growth of 2 ln L of the outputs' common part, less the price of the sides
  double evidence = 0;  // the same summed over the outputs, as the evidence of a cause is
};

// series: rows x outputs. Both sides hold a tenth of the rows or more. The outputs are taken
// together as they show the sides best; what is left without the sides may be any shape of
// `noise_grid`, so that slow noise does not pass for sides. Nothing where the sides are not apart
// or do not pay their price, and where one of the channels (rows x k) tells the side all but
// without exception: a bump on a guide is at its place, a robot that gives way is off under its
// load, and a tip that never strays cannot be told from either.
std::optional<TwoSides> two_sides(const Timeline& timeline, const SoftBase& simulation,
                                  const Eigen::MatrixXd& series,
                                  const Eigen::MatrixXd& channels = {});

}  // namespace driftwise::diagnosis
