#include "server/diagnosis/u90.h"

#include <cmath>

#include "server/core/units.h"

namespace driftwise::diagnosis {

double u90_of(const Eigen::VectorXd& residuals) {
  if (residuals.size() < 2) return NAN;
  return kSigmaToU90 * std::sqrt((residuals.array() - residuals.mean()).square().sum() /
                                 static_cast<double>(residuals.size() - 1));
}

}  // namespace driftwise::diagnosis
