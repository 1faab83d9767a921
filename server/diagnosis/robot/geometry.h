#pragma once
// geometry_parameter: which numbers of a robot's drawing are wrong, and by how much.
//
// About the identified robot the outputs are linear in the parameters (a deviation of a millimetre
// in a metre leaves a micrometre), so each parameter is one column over all outputs together with
// one coefficient. Discrepancy and columns are whitened by the noise of each output and freed of
// the correlation between outputs; what is not in these kinematics counts as noise there, with its
// autocorrelation. Where the robot stands is always in. Then ParameterSelection.
//
// What such data could not tell apart about the drawing is not offered: held names it with the
// reason (server/identification/identifiability.h).

#include <functional>
#include <memory>
#include <vector>

#include "server/diagnosis/answer/diagnosis.h"
#include "server/diagnosis/rows/problem.h"
#include "server/identification/identify.h"

namespace driftwise::diagnosis {

struct GeometryDiagnosis {
  std::vector<Finding> findings;            // strongest first
  std::vector<NotTestable> held;            // "geometry_parameter link2.d_mm"
  identification::Identification nominal;   // the drawing, placed
  identification::Identification extended;  // the same with the named parameters identified
};

// The dataset with the problem's learning rows as calibration and its judging rows as validation;
// every other row is excluded.
Dataset marked_rows(Dataset dataset, const Problem& problem);

// problem: of this dataset, its outputs those of the mechanism in its order, one row per block.
// Learns from the rows that learn, judges by those that judge. terms: linear in every output,
// always in beside the drawing. Errors: those of identification::identify; cancelled (tick said
// false).
Result<GeometryDiagnosis> diagnose_geometry(
    const Dataset& dataset, const Problem& problem,
    const std::shared_ptr<const kinematics::Mechanism>& mechanism,
    const std::vector<effects::Term>& terms, double alpha, const std::function<bool()>& tick);

}  // namespace driftwise::diagnosis
