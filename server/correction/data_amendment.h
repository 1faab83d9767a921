#pragma once
// What a diagnosis found wrong with the instruments or the data, laid over a dataset before
// anybody fits it. The points in the record stay as they were measured: an amendment that is undone
// leaves no trace in them.
//
// A shift is what a length read too much: x_true = x_read - sum of mm * term. It counts from the
// datum's zero, as every length does: where the zero was taken it is 0, with the lengths and tilts
// there 0 and everything else as it stood at the datum's first row.

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "server/core/cell_time.h"
#include "server/core/data/dataset.h"
#include "server/core/ids.h"
#include "server/core/result.h"
#include "server/effects/term.h"

namespace driftwise::correction {

struct LengthShift {
  std::string axis;                  // "x"
  std::vector<effects::Term> terms;  // of what was measured
  std::vector<double> mm;            // per unit of each term
  // Runs that the shift holds for, where it does not hold for every run that the cell measured:
  // terms that read the data's own clock (drift, a period in time) mean something in the runs they
  // were found in only, and what was found in a file is of the file's instrument. Empty: all those.
  std::vector<RunId> runs;
  CellTime clock_origin;  // what time_s counted from there
  // Id of the instrument whose error it is. Where `runs` is empty the shift is for the runs whose
  // axis it measured: who lays it over says which (application/datasets/instruments.h). Empty: not
  // known.
  std::string device = {};
  bool operator==(const LengthShift&) const = default;
};

// The same of a rotation that drifts by itself, such as one that is seen over a 45 degree mirror
// whose mount warms: rotation_true = rotation_read - sum of arcsec * term. Lengths stay as they
// were corrected with the rotation that was read.
struct AngleShift {
  std::string axis;  // "ry"
  std::vector<effects::Term> terms;
  std::vector<double> arcsec;    // per unit of each term
  std::vector<double> u_arcsec;  // standard uncertainty of each
  std::string source;            // where they come from: "41 returns to zero of run 3"
  std::vector<RunId> runs;       // empty: every run that the cell measured
  CellTime clock_origin;
  bool operator==(const AngleShift&) const = default;
};

struct DatumSplit {  // from this row of the trajectory on, in time, it is another datum
  RunId run;
  std::int64_t row = 0;
  bool operator==(const DatumSplit&) const = default;
};

struct SensorLeftOut {
  RunId run;
  std::string symbol;  // "t07"
  bool operator==(const SensorLeftOut&) const = default;
};

struct DataAmendment {
  std::vector<LengthShift> shifts;
  std::vector<DatumSplit> splits;
  std::vector<SensorLeftOut> sensors;
  std::vector<AngleShift> angles = {};
  bool operator==(const DataAmendment&) const = default;
  bool empty() const {
    return shifts.empty() && splits.empty() && sensors.empty() && angles.empty();
  }
};

struct RowOrigin {  // where a row of a dataset comes from
  RunId run;
  std::int64_t row = 0;  // of its trajectory
  bool of_file = false;  // imported: measured by instruments of another place
};

// origins: one per row of the dataset; time_zero: what its time_s counts from (utc_ns 0: a file).
// A length whose shift needs a channel that the dataset has not at all stays as it was measured; in
// a row that misses only the value the length is missing. Sensors: the column goes when any of the
// dataset's runs has it left out. Errors: those of effects::TermEvaluator::create.
Result<void> amend(const DataAmendment& amendment, const std::vector<RowOrigin>& origins,
                   CellTime time_zero, Dataset& dataset);

}  // namespace driftwise::correction
