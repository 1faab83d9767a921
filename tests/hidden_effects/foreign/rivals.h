#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "tests/hidden_effects/foreign/hidden.h"
#include "tests/hidden_effects/foreign/strength.h"

namespace driftwise::foreign {

// Another explanation of an effect, and what it would leave: 2 ln L between truth and it.
struct Rival {
  std::string cause;
  std::string subject;
  double gap = 0.0;
};

// Best rival per cause and subject, nearest first, over a grid of each cause's parameters.
//
// Amplitudes of a rival are free per pose coordinate, so gaps are never too large. `beside`: the
// effect of a second hidden cause that is known (pairs), or empty.
std::vector<Rival> rivals_of(const Campaign& campaign, const Whitened& whitened,
                             const Eigen::MatrixXd& effect, const Eigen::MatrixXd& beside);

}  // namespace driftwise::foreign
