#pragma once
// Errors of an arm's joints that a dataset shows: joint_compliance, gear_error, joint_offset_drift,
// backlash. arm_causes.h is their catalogue, arm_search.h the evidence.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/diagnosis/robot/arm_search.h"
#include "server/diagnosis/rows/problem.h"
#include "server/kinematics/mechanism.h"

namespace driftwise::diagnosis {

struct ArmDiagnosis {
  std::vector<Finding> findings{};  // strongest first
  std::vector<NotTestable> not_testable{};
  std::vector<std::string> warnings{};  // causes that the gate refused
  KinematicsDescription robot;          // the drawing with the joints' errors
  // With the joints' angles where their plays by motion let them be, as no robot file has it;
  // nothing where there are none.
  std::optional<Dataset> behind_plays{};
};

// mechanism: a serial arm. Parameters otherwise as for diagnose_geometry(); its errors.
Result<ArmDiagnosis> diagnose_arm(const Dataset& dataset, const Problem& problem,
                                  const std::shared_ptr<const kinematics::Mechanism>& mechanism,
                                  const std::vector<effects::Term>& terms, double alpha,
                                  const std::function<bool()>& tick);

}  // namespace driftwise::diagnosis
