#pragma once
// The door of a diagnosis: data in any unit of the format become data in the catalogue's units
// (mm, arcsec, degC, hPa), and coefficients found there become those of the user's columns.

#include "server/calibration/model/fit_options.h"
#include "server/core/data/dataset.h"
#include "server/effects/term.h"

namespace driftwise::diagnosis {

// Motor and pose coordinates in mm or arcsec, temperatures in degC, pressures in hPa; every other
// column as it is. Data that are in these units already stay as they are to the last digit.
Dataset in_catalogue_units(const Dataset& dataset);

// The same baseline for such data: periods and widths in nm or arcsec.
calibration::Candidates in_catalogue_units(const calibration::Candidates& baseline);

// The coefficient of a term on an output, for the user's units: this times the one found in the
// catalogue's. dataset: the user's.
double coefficient_factor(const Dataset& dataset, const effects::Term& term,
                          const std::string& output);

}  // namespace driftwise::diagnosis
