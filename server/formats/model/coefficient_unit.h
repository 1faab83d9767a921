#pragma once
// What a coefficient is in: the output's unit over the units of its term's factors.

#include <string>

#include "server/calibration/model/model.h"

namespace driftwise::formats {

// "mm/mm^2", "mm/degC", "mm/(mm degC)", "mm/(K/h)". Units of channels come from the model's domain,
// which knows those of the terms that are in; "" where a unit is not known.
std::string coefficient_unit(const calibration::OutputModel& output, const effects::Term& term,
                             const calibration::Model& model);

}  // namespace driftwise::formats
