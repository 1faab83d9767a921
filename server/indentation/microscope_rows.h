#pragma once
// The microscope's indents as those that were made, by the numbers of their contacts. Pure.

#include <span>
#include <vector>

#include "server/indentation/indent_table.h"
#include "server/indentation/procedure.h"

namespace driftwise::indentation {

// A row of the microscope's table: an indent by the number of its contact on the substrate.
struct MicroscopeIndent {
  int id = 0;
  double x_um = 0, y_um = 0;
  double pixel_nm = 0, marking_px = 0;
  int pictures_joined = 0;
  double diagonal_um = 0;  // 0: not measured
};

// Distances from the common zero along each line. Errors: invalid_argument NO_SUCH_ROW (an indent
// was not measured); IDS_SHIFTED: a row lies at the place of another indent than its number says,
// as when an interrupted contact left no mark and the numbers after it are one too small;
// WRONG_COORDINATES: all rows would lie at their places in a mirrored or turned picture.
Result<std::vector<Indent>> indents_seen(const ProcedureRecord& record,
                                         std::span<const MicroscopeIndent> rows);

}  // namespace driftwise::indentation
