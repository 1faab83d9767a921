#pragma once
// Models by sets by outputs: several formulas fitted to the same calibration rows, each judged on
// several named sets of the rows marked validation.

#include <string>
#include <vector>

#include "server/calibration/fit.h"
#include "server/core/data/accuracy.h"

namespace driftwise::identification {

// Rows whose channel lies within [low, high]; several conditions hold together.
struct RowCondition {
  std::string symbol;
  double low = 0, high = 0;
};
struct NamedSet {
  std::string name;
  std::vector<RowCondition> conditions;  // empty: every validation row
  // Word of the column `set` (server/formats/csv/set_names.h); empty: any validation row.
  std::string word{};
};
// "inside: force 0.7..0.8, x -1..1". Errors: invalid_argument BAD_SET.
Result<NamedSet> named_set_from(const std::string& text);

struct NamedFit {
  std::string name;
  calibration::FitOptions fit;  // with its candidates
};

struct SetFigures {  // of one output; column unit
  Channel output;
  ErrorFigures figures;
};
struct SetCell {
  std::string model, set;
  std::int64_t rows = 0;  // of the set that the figures are of: every value that the model reads
  std::vector<SetFigures> outputs;
};
struct SetTable {
  std::vector<std::string> models, sets;
  std::vector<std::int64_t> rows;   // of each set, those without a value included
  std::vector<std::int64_t> terms;  // of each model, sum over the outputs
  std::vector<SetCell> cells;       // models by sets, in that order
  // Validation rows that no set has: their datum has no calibration rows.
  std::int64_t rows_unknown_datum = 0;
};

// The rows, and the datum that they are predicted in, are those of fit(): its figures of validation
// rows and these are the same.
//
// words: of the column `set`, one per row; empty: it names no sets. Errors: those of fit();
// invalid_argument UNKNOWN_CHANNEL (a condition), NO_ROWS (a set without a row).
Result<SetTable> set_table(const Dataset& dataset, const std::vector<NamedFit>& models,
                           const std::vector<NamedSet>& sets,
                           const std::vector<std::string>& words = {});

}  // namespace driftwise::identification
