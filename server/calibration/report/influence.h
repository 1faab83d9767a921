#pragma once
// How a systematic error of a measured channel passes into a model.
//
// A fit takes its data at their word: if x was wrong by h(row) in every row, the outputs it was
// offered are f(true x) against the rows' x = true x + h, and to first order the coefficients move
// by what least squares makes of -(df/dx) h. Served at a pose, the model then errs by that shift,
// whereas nothing in its residuals shows it. So each systematic contribution to a target's
// uncertainty is one vector of coefficient shifts, found with the same columns and the same weights
// as the fit itself, and what a constant or another term absorbs is absorbed here too
// (docs/uncertainty.md; JCGM 100:2008, 5.1.3 and F.1.2.3).

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/calibration/linear/projection.h"
#include "server/calibration/model/model.h"
#include "server/calibration/noise/noise_spectrum.h"

namespace driftwise::calibration {

// For every pose coordinate the output reads (x, y, z): an offset ("1"), a factor and the leakage
// of its neighbours ("x_mm" ..), the lever arms ("rx_arcsec" ..) as far as the data have them, a
// steady drift since the zero of the datum ("h", hours) and one that goes with a thermometer since
// then ("t04_degC", K). Of every pose coordinate, with noise: the error of the reading at the zero,
// which the rows have as far as the noise keeps it ("zero"): noise's correlation with the row
// before the first. For the force and every other channel of a term (temperatures): an offset.
// Channels under an effect with memory count as constants there. What an error goes with counts in
// the rows that have a reading of it, where these are a tenth of all and more than the terms.
// Errors: those of raw_columns.
Result<std::vector<Influence>> influences_of(const Excerpt& rows, const Projection& projection,
                                             const NoiseSpectrum& noise, const OutputModel& output);

// By what an error of this channel may go from row to row, each with its name (Influence::by);
// kMissing where what it goes with was not read. unknowns: that the fit has; what fewer rows have
// is left out.
std::vector<std::pair<std::string, Eigen::VectorXd>> error_shapes(const Excerpt& rows,
                                                                  const NoiseSpectrum& noise,
                                                                  const std::string& symbol,
                                                                  std::size_t unknowns);
// Of the rows that have a reading.
std::vector<Eigen::Index> rows_read(const Eigen::VectorXd& shape);

// Fills output.influences. rows: of the calibration, in time order; at most about 4000 of them are
// looked at, evenly spread: there is no noise to average. Errors: as above.
Result<void> add_influences(const Dataset& dataset, const std::vector<std::size_t>& rows,
                            const std::string& weight_symbol, const NoiseSpectrum& noise,
                            OutputModel& output);

// Names the channels that errors of the outputs may go with (pose coordinates, thermometers) and
// that lack a reading in more than a tenth of these rows; a sentence for Model::warnings.
std::optional<std::string> sparse_readings(const Dataset& dataset,
                                           const std::vector<std::size_t>& rows,
                                           const std::vector<OutputModel>& outputs);

}  // namespace driftwise::calibration
