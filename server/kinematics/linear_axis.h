#pragma once
// One linear axis: q = (x - offset) (1 + scale). Its identification is the smallest there is: where
// zero lies, and how long the scale's millimetre is.

#include "server/kinematics/mechanism.h"

namespace driftwise::kinematics {

class Axis final : public Mechanism {
 public:
  static Result<Axis> create(const KinematicsDescription& description);

 private:
  using Mechanism::Mechanism;
  Prediction evaluate(std::span<const double> inputs, const Eigen::VectorXd& values,
                      Derivatives derivatives) const override;
};

}  // namespace driftwise::kinematics
