#pragma once
// Questions about the data of a model before it serves: who measured them, what they could show.
// Sentences that follow "although", each with its figure. Pure.

#include <optional>
#include <string>
#include <vector>

#include "server/calibration/model/model.h"
#include "server/core/data/dataset.h"
#include "server/core/description/cell_description.h"
#include "server/core/ids.h"

namespace driftwise::application {

// One run that a model was fitted from.
struct DataOfModel {
  RunId run;
  std::string name;
  bool measured_here = true;         // false: its rows are a file's
  std::optional<Dataset> rows;       // of a file
  std::optional<double> duration_s;  // from the first to the last row; none: not known
};

// Rows of a file: their instruments and thermometers are not this cell's as far as the record
// knows. Motor coordinates beyond the soft limits of the cell are named.
std::vector<std::string> origin_questions(const calibration::Model& model,
                                          const std::vector<DataOfModel>& data,
                                          const CellDescription& cell);

// A campaign of this cell that could not show what a target depends on: no term reads a thermometer
// of the robot; no row judged the model (judged_later: a run that was measured afterwards did); it
// lasted minutes.
std::vector<std::string> campaign_questions(const calibration::Model& model,
                                            const std::vector<DataOfModel>& data,
                                            const CellDescription& cell, bool judged_later);

}  // namespace driftwise::application
