#pragma once
// A Jacobian by central differences with Richardson's extrapolation, from predicted values alone.

#include <Eigen/Core>
#include <vector>

#include "server/kinematics/mechanism.h"

namespace driftwise::kinematics {

inline Eigen::MatrixXd jacobian_by_differences(const Mechanism& mechanism,
                                               const std::vector<double>& inputs,
                                               const Eigen::VectorXd& values) {
  const auto slope = [&](Eigen::Index k, double step) -> Eigen::VectorXd {
    Eigen::VectorXd up = values, down = values;
    up[k] += step;
    down[k] -= step;
    return (mechanism.predict(inputs, up).value - mechanism.predict(inputs, down).value) /
           (2 * step);
  };
  Eigen::MatrixXd jacobian(static_cast<Eigen::Index>(mechanism.outputs().size()), values.size());
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    const double step = mechanism.parameters()[static_cast<std::size_t>(k)].natural;
    jacobian.col(k) = (4 * slope(k, step / 2) - slope(k, step)) / 3;
  }
  return jacobian;
}

// Nominal values, each moved by its natural deviation times a number that differs from one to the
// next.
inline Eigen::VectorXd moved_values(const Mechanism& mechanism) {
  Eigen::VectorXd values = nominal_values(mechanism.parameters());
  for (Eigen::Index k = 0; k < values.size(); ++k)
    values[k] += mechanism.parameters()[static_cast<std::size_t>(k)].natural *
                 std::sin(1.7 * static_cast<double>(k) + 0.3);
  return values;
}

}  // namespace driftwise::kinematics
