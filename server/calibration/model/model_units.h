#pragma once
// Values of a cell or a file in the units that a model has.
//
// A model names its channels by symbol and was fitted in the units of its own data ("t04" in K,
// "x" in um). Whoever puts other data or a zero's values into its terms brings them there first:
// serving, the check standard, residuals and verification all do it with these functions.

#include <vector>

#include "server/calibration/model/model.h"
#include "server/core/data/dataset.h"
#include "server/core/data/reading.h"
#include "server/core/result.h"
#include "server/core/unit_conversion.h"

namespace driftwise::calibration {

// From the unit in which a channel is read to the model's, of the same symbol. A spread ("t04_std")
// is a difference and has no offset. Errors: invalid_argument UNITS_DISAGREE (no units of one
// kind).
Result<UnitConversion> to_model_unit(const Channel& read, const Channel& of_model);

// The same rows: every channel that the model reads or gives, and what was commanded of those that
// it gives, in the model's unit and named by it. Other columns stay as they are.
Result<Dataset> in_model_units(const Model& model, Dataset data);

// The same for values by channel, such as those at a zero; a name that is no channel stays.
Result<std::vector<ChannelValue>> in_model_units(const Model& model,
                                                 std::vector<ChannelValue> values);

}  // namespace driftwise::calibration
