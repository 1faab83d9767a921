#pragma once
// Where the zeros of a fit's further datums lie.
//
// A datum zeroes the instruments, not the robot: when the robot has warmed since the first datum,
// pose 0 of the next is another place in the first one's frame, p0. Rows of that datum obey q =
// f(pose + p0, ...), not f(pose, ...) + constant: the two differ wherever the geometry is curved or
// a term is a product of pose and something (docs/decisions/0005).
//
// How: the fit as it is, datum(k) always in, gives the constant c_k of every output; p0 grows by
// slopes^-1 c_k, slopes being the mean derivatives of the outputs by the axes over that datum's
// calibration rows; the rows are moved and the whole fit, selection included, is made again, until
// the constants are gone. Each pass is an ordinary fit to rows that are known: no rule of selection
// changes, and as many numbers are estimated per datum as before, one per axis instead of one per
// output. Rows moved by any vector come to the same place.
//
// A datum keeps its constant alone, and says why, where there are not as many axes (x, y, z among
// the terms, lengths, of the outputs' robot where a cell has several) as outputs (motor
// coordinates, lengths), where the outputs do not follow the axes, where p0 is beyond 2 % of a
// fitted range (its scales were homed elsewhere), and where its rows fit clearly better with the
// constant than moved.

#include <vector>

#include "server/calibration/fit.h"

namespace driftwise::calibration {

// One per datum(k) of the fit, ascending; empty where there is one datum only, where datums are not
// to be moved (FitOptions::move_datums), or where the fit itself would fail.
std::vector<DatumZero> find_datum_zeros(const Dataset& dataset, const FitOptions& options);

// Whether any of them moves rows.
bool any_moved(const std::vector<DatumZero>& zeros);

// The same rows with the poses of every moved datum in the first one's frame: what a model with
// these zeros must be asked about. Datums are counted as datum(k) terms count them.
Dataset in_first_datum(Dataset dataset, const std::vector<DatumZero>& zeros);

}  // namespace driftwise::calibration
