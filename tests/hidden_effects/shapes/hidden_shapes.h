#pragma once
// What is hidden, of any size: make() scales it.

#include "tests/hidden_effects/shapes/hidden_path.h"

namespace driftwise::hidden {

struct Scene {
  Robot robot = Robot::linear_axis;
  Path path;
  Weather weather;
  std::vector<std::vector<double>> read_degc;  // [sensor][row], as the thermometers say
  std::vector<std::array<double, 3>> tilt_arcsec;
  Eigen::Matrix3d motor_from_pose;  // the linear axis uses its first element
  int first_sensor = 5;             // t05
  int outputs() const { return robot == Robot::linear_axis ? 1 : 3; }
};

struct Shape {
  Eigen::MatrixXd values;  // rows x outputs
  std::string subject;
  std::string baseline_less;  // terms that the baseline must lack for it to be missing: " - t07"
};

// Throws std::invalid_argument for a cause that nothing hides.
Shape shape_of(const Hidden& hidden, const Scene& scene, std::mt19937_64& random);

}  // namespace driftwise::hidden
