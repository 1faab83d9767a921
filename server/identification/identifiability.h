#pragma once
// Which parameters the data can tell apart.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "server/kinematics/mechanism.h"

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

// Names of the parameters that the mechanism with these values hides whatever its posture: held for
// good by a robot file. What rows hide because a joint stood still, the next rows may show. inputs:
// inputs x rows, that say where lengths lie; angles go all round. The description's own holds are
// not among the names.
std::vector<std::string> hidden_in_every_posture(const kinematics::Mechanism& mechanism,
                                                 const Eigen::VectorXd& values,
                                                 const Eigen::MatrixXd& inputs);

// Of a Jacobian: covariance / variance, that is (J'J)^-1, by its singular values. Errors are the
// caller's to exclude: J has full rank.
Eigen::MatrixXd inverse_normal(const Eigen::MatrixXd& jacobian);

}  // namespace driftwise::identification
