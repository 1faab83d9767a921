#pragma once
// The catalogue of arms: errors of joints beyond the drawing (server/kinematics/joint_errors.h),
// each as the turns of a joint that a unit of its numbers gives on every row of a dataset.
//
// Typical amplitudes, with their sources: docs/diagnosis.md, "Physics". Nothing here
// knows an arm but by its drawing.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/core/description/kinematics_description.h"
#include "server/diagnosis/answer/diagnosis.h"

namespace driftwise::diagnosis {

struct ArmCause {
  std::string id;         // of the catalogue: "joint_compliance"
  std::string subject;    // "joint2", "joint2 t04"
  std::size_t joint = 0;  // from 0
  int harmonic = 0;       // of a gear error
  Channel channel{};      // of a drift
  double reference = 0;   // ... counted from this, degC
  // Rows x numbers (two for a harmonic: cosine and sine), rad per unit.
  Eigen::MatrixXd turns_rad{};
  // What the turn is a function of: torque, angle or temperature, one per row.
  Eigen::VectorXd driver{};
  double typical = 1;       // standard deviation of the prior, in units
  double range = 20;        // of the amplitude, over typical
  double of_noise = 0;      // typical is at least so many sd of the rows, at the largest turn
  bool one_signed = false;  // a negative amplitude is not this cause
  bool certain = false;     // acts on every arm: only its size is asked
  bool by_motion = false;   // of a play: the way that the joint came chooses the flank
};

struct ArmCatalogue {
  std::vector<ArmCause> causes;
  std::vector<NotTestable> not_testable;
};

// rows: those that the search learns from. A cause that they cannot show is listed with the reason.
// Nothing is offered where the data lack a joint angle.
ArmCatalogue arm_causes(const Dataset& dataset, const std::vector<std::size_t>& rows,
                        const KinematicsDescription& arm);

// The description with these numbers added to a joint's errors. amplitude: one per column of
// turns_rad. Nothing is added for a play by motion: a robot file says nothing of the way that a
// joint came.
void add_to(KinematicsDescription& arm, const ArmCause& cause, const Eigen::VectorXd& amplitude);

}  // namespace driftwise::diagnosis
