#pragma once
// Which parameters the data can tell apart.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "server/kinematics/parameter.h"

namespace driftwise::identification {

struct Identifiability {
  std::vector<char> free;          // per parameter: to be identified
  std::vector<std::string> notes;  // per parameter: "" or why it is held
  double condition = 1;  // largest to smallest singular value of the free columns at unit length
};

// jacobian: measured values x parameters, per natural unit of each. A column that is a combination
// of others to kApart of its length cannot be told from them: of such a set the parameter with the
// highest rank is held, and its note names the others. Parameters that the description holds are
// held. Found by orthogonalising the columns in the order of their ranks; the condition comes from
// the singular values.
Identifiability identifiable(const Eigen::MatrixXd& jacobian,
                             const kinematics::Parameters& parameters);

// Of a Jacobian: covariance / variance, that is (J'J)^-1, by its singular values. Errors are the
// caller's to exclude: J has full rank.
Eigen::MatrixXd inverse_normal(const Eigen::MatrixXd& jacobian);

}  // namespace driftwise::identification
