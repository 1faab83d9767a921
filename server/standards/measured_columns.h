#pragma once
// A dataset's columns in the units that the standards' arithmetic uses.

#include <string>
#include <string_view>
#include <vector>

#include "server/core/data/dataset.h"

namespace driftwise::standards {

// The column of this symbol in mm (nm, um, m are converted), or in arcsec; one value per row.
// Errors: invalid_argument; NO_COLUMN naming the columns there are, UNIT_KIND.
Result<std::vector<double>> column_mm(const Dataset& dataset, std::string_view symbol);
Result<std::vector<double>> column_arcsec(const Dataset& dataset, std::string_view symbol);

// The first of these symbols that the dataset has; empty when it has none.
std::string first_present(const Dataset& dataset, const std::vector<std::string>& symbols);

// Of the rows in use: in more than one datum a new zero in between shifts all that follows.
std::size_t datum_count(const Dataset& dataset);

// time_s of the first and of the last row in use; kMissing: untimed, or none is in use.
struct TimeSpan {
  double first_s = kMissing, last_s = kMissing;
};
TimeSpan time_span(const Dataset& dataset);

}  // namespace driftwise::standards
