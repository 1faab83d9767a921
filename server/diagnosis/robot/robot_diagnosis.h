#pragma once
// What the simulation of a robot by its drawing gets wrong: of an arm, errors of its joints beyond
// all numbers of the drawing (arm_diagnosis.h); then the drawing's own numbers (geometry.h); then,
// beyond the robot so identified, every other cause of the catalogue (diagnosis.h). Numbers of the
// drawing do not count towards max_findings.
//
// Isolated wrong rows: where there are any, all of it is done again without them.
//
// The second look is at what the first leaves: an effect that resembles a geometric deviation has
// partly been taken up by it. That hides effects and invents none.

#include <memory>

#include "server/diagnosis/answer/diagnosis.h"
#include "server/kinematics/mechanism.h"

namespace driftwise::diagnosis {

struct RobotDiagnosis {
  Diagnosis diagnosis;  // "before" is the drawing, placed by a fit; "after" all findings
  // The drawing with the named numbers as identified. It holds what the drawing held, and what the
  // drawing hides in every posture.
  KinematicsDescription robot;
};

// options.baseline: its terms are in beside the drawing; its outputs are the mechanism's, or none.
// Errors: those of diagnose() and identification::identify; invalid_argument OTHER_OUTPUTS.
Result<RobotDiagnosis> diagnose_robot(const Dataset& dataset,
                                      const std::shared_ptr<const kinematics::Mechanism>& mechanism,
                                      const DiagnoseOptions& options);

}  // namespace driftwise::diagnosis
