#pragma once
// What the cell's owner declares about the instruments, as systematic errors of channels: the type
// B part of a target's budget (JCGM 100:2008, 4.3). Entries are independent of one another but for
// those of one cause. What each line means, its distribution, and what is left out:
// docs/uncertainty.md.

#include <string>
#include <vector>

#include "server/calibration/model/model.h"
#include "server/compensation/snapshot.h"
#include "server/core/description/cell_description.h"

namespace driftwise::compensation {

struct DeclaredError {
  UncertaintySource source;
  std::string symbol;  // of the channel in error: "x"
  std::string by;      // "1", "h", or the symbol of what it goes with: "ry", "y", "t04"
  // Standard uncertainty in the channel's summary unit (nm, arcsec; K, N) per mm, arcsec, hour or K
  // of by; hours and kelvin since the zero. With a sign where the cause has other errors.
  double u = 0;
  // An error of the zero's own reading as well, so that a datum carried to its zero is free of it.
  bool shared_with_zero = true;
  bool is_reading_at_zero = false;  // drawn from the noise that the rows have as well
  // Errors of one source and one cause are one error: "t04" or "h" of a drift, "rz" of a rotation
  // that acts on several lengths. Their effects add with their signs. Empty: alone.
  std::string cause{};
};

using MeasuredCoordinates = std::vector<MeasuredBy>;

// measured_by: of the model's rows (Lineage). An instrument's errors count with its weight in the
// coordinate: all of them where it alone measured it, none where another did. Of a coordinate that
// is not in there, those of every instrument that gives it.
std::vector<DeclaredError> declared_errors(const CellDescription& cell,
                                           const MeasuredCoordinates& measured_by);

// Standard uncertainty of one value of this coordinate, its share of a fit's residual: of a length
// or a motor coordinate in nm, of a rotation in arcsec. 0 where nothing is declared. Where several
// instruments give the coordinate, that of those which measured it: the root mean square over the
// rows, of a mean of n readings the root of the sum of squares over n. Where that is not stated,
// the least of theirs: no more is taken off a residual than any of them brought.
double reading_noise(const CellDescription& cell, const std::string& symbol,
                     const MeasuredCoordinates& measured_by);

// nm of a result per unit of an output's column; of an angle 1e-6 arcsec, as in a snapshot.
double nm_per_unit(const Channel& output);

// Variance that the declared noise of the instruments that read output and pose gives the residual
// of a fit, nm^2 (nm_per_unit); the rest of it is the robot's own.
double instrument_noise_nm2(const calibration::OutputModel& output, const CellDescription& cell,
                            const MeasuredCoordinates& measured_by);

}  // namespace driftwise::compensation
