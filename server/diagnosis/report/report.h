#pragma once
// From what a search found to what a diagnosis says.

#include <vector>

#include "server/diagnosis/answer/diagnosis.h"
#include "server/diagnosis/growth/extension.h"
#include "server/diagnosis/noise/two_sides.h"
#include "server/diagnosis/search/coordinate_frame.h"

namespace driftwise::diagnosis {

// Numbers, intervals, held-out gain and sentence of each of the named. frame: where the problem is
// in it the findings' outputs are its motors.
std::vector<Finding> findings_of(const Problem& problem, const std::vector<Cause>& causes,
                                 const Extension& extension,
                                 const std::optional<CoordinateFrame>& frame = {});

// Readings on two sides: of which coordinate, and how far apart. The coordinate is that of the
// baseline's variables whose column is spread over the outputs as the sides are, else the output
// that has most of them.
Finding probe_hysteresis(const Problem& problem, const TwoSides& sides);

// Figures and residuals of every output, before and after the extension; in a frame of its motors.
std::vector<OutputSummary> outputs_of(const Problem& problem, const Dataset& dataset,
                                      const Extension& extension,
                                      const std::optional<CoordinateFrame>& frame = {});

// The baseline with the findings' terms, each once.
std::string extended_formula(const std::string& baseline, const std::vector<Finding>& findings);

}  // namespace driftwise::diagnosis
