#pragma once
#include <string>

#include "server/core/data/dataset.h"
#include "server/effects/term.h"

namespace driftwise::cli {

// fit --validation FILE: the rows of a second file as the validation set of the first.
//
// Time: by the files' own "# time_zero" where both have one, so that memory runs from one into the
// other in the order in which they were measured; else the second begins where the first ends,
// which is supposed: times_are_related().
// Datum: as run and datum say where both files have them. Where only one has, the other's rows lie
// in its one datum; where neither has, all rows do. Rows whose datum the first file does not have
// are left out by the fit, which says so: their constant is not known.
//
// Throws Failure (bad_input): the first file marks validation rows itself (two answers to one
// question); only one of them has time_s; a channel in two units; a datum that cannot be told.
// Channels of the first that the second lacks are missing there.
Dataset with_validation_rows(const Dataset& calibration, const std::string& calibration_name,
                             const Dataset& validation, const std::string& validation_name);

// Whether it is known how long after the first's rows the second's were measured: both say their
// time_zero, or neither has times.
bool times_are_related(const Dataset& calibration, const Dataset& validation);

// Whether a term of a row depends on rows before it or on the data's time.
bool depends_on_times(const effects::Term& term);

}  // namespace driftwise::cli
