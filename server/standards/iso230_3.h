#pragma once
// How far positions wander while the temperatures change, after the manner of ISO 230-3: the test
// of environmental variation (one position at rest) and of distortion by moving axes (positions
// visited again and again from the same side).
//
// Of each series the deviation e(t) = measured - target - (the same at its first visit):
//   range = max e - min e over the whole test; change after 60 min and at the end; slope by least
//   squares in nm per hour; and for windows of given lengths the largest range within any window of
//   that length: what a job of that length sees at worst. Between two visits e is on the straight
//   line: a window's edge and the 60 min seldom fall on a visit.
// Sources: docs/standards.md.

#include <string>
#include <vector>

#include "server/standards/approaches.h"
#include "server/standards/conditions.h"

namespace driftwise::standards {

inline constexpr std::size_t kMostWindows = 32;  // each is a pass over the visits

struct Iso2303Options {
  AxisColumns columns = {};
  double hours = 4;                                 // the test lasts at least so long
  std::vector<double> windows_min = {15, 60, 240};  // those longer than the test are left out
  double longest_gap_min = 30;                      // between two visits of a position
};

struct DriftWindow {
  double minutes = 0, range_nm = 0;
  double from_h = 0;  // where the worst window begins, from the test's first row
};

struct DriftSeries {
  double target_mm = 0;
  ApproachSide side = ApproachSide::unknown;  // unknown: at rest
  std::size_t visits = 0;
  double duration_h = 0;
  double range_nm = 0, after_60_min_nm = kMissing, at_end_nm = 0, slope_nm_per_h = 0;
  std::vector<DriftWindow> windows;
};

struct Iso2303 {
  AxisColumns columns;
  std::vector<DriftSeries> series;  // by rising target
  double range_nm = 0;              // the largest of them
  Conditions conditions;
  std::vector<std::string> warnings;
};

// A position's series are its visits from one side, or at rest; those that span less than nine
// tenths of the test, or leave gaps longer than longest_gap_min, are left out, with a warning.
// Returns to zero are a position like any other here, without the warning.
// Errors: invalid_argument OUT_OF_RANGE for a duration that is not above 0 and for more than
// kMostWindows windows; those of find_axis_columns and column_mm; failed_precondition: UNTIMED,
// TOO_SHORT, NO_SERIES naming what each position lacks.
Result<Iso2303> iso230_3(const Dataset& dataset, const Iso2303Options& options);

}  // namespace driftwise::standards
