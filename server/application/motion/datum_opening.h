#pragma once
// Zeroing: a new datum, with every temperature at that instant.

#include <optional>
#include <string>
#include <vector>

#include "server/application/motion/start_checks.h"
#include "server/application/motion/workbench.h"
#include "server/application/motion/zero_shift.h"

namespace driftwise::application {

struct DatumOpening {
  std::string reason;  // "start", "restart after a kill", "beam lost", "reference lost"
  bool home = false;   // reference the axes in any case
  bool check_drift = false;
  // What the run knows of the datum before, to compare with: only with a beam that was kept.
  std::optional<DatumRecord> before;
  Closures closures;
};

// Device of the reading that is stored before the first instrument is zeroed. Its values are
// zero_predicted_nm .. zero_limit_nm; it has none where the old zero was not compared.
inline constexpr const char* kZeroDevice = "zero";

// Checks, homes, moves to zero, reads the zero as the old datum sees it, stores the comparison
// (kZeroDevice), zeroes, stores the datum and its event. The record's values: q1_mm .. where the
// new zero lies on the scales, x_mm .. as the old zero had it (absent with a lost beam, and where
// the instruments were zeroed since the datum before), rotations as the autocollimators read them,
// every temperature, the force that acts; with a datum before also zero_predicted_nm,
// zero_found_nm, zero_difference_nm, zero_limit_nm of the length that differs most, by the first
// zeroing since that datum. Readings before and after the zeroing have the budget of a row
// (zero_visit.h). A run waits while the disk takes nothing. Errors: those of the checks and
// devices; ZERO_NOT_REACHED; those of the store, without a run resource_exhausted among them;
// SERVO_OFF where switch_on does not allow it.
Awaitable<Result<DatumRecord>> open_datum(RunScope& scope, DatumOpening opening,
                                          SwitchOn switch_on = SwitchOn::no);

// The warming of every temperature of the cell between a datum's zeroing and a set of values;
// missing ones count 0.
std::vector<double> warming_since(const CellDescription& description, const DatumRecord& datum,
                                  const std::vector<ChannelValue>& values);
const double* find_value(const std::vector<ChannelValue>& values, const std::string& channel);

// What each length of the cell shows at a return to zero, nm since the zeroing; kMissing where a
// value is. With one axis and one length the scale's own reading is taken out; with several the
// pose depends on all axes at once, and what they hold (some 10 nm) stays in.
std::vector<double> closure_nm(const CellDescription& description, const DatumRecord& datum,
                               const std::vector<ChannelValue>& values);
// The one of largest size; kMissing when there is none.
double largest_nm(const std::vector<double>& closure_nm);

}  // namespace driftwise::application
