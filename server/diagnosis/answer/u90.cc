#include "server/diagnosis/answer/u90.h"

#include <cmath>
#include <span>

namespace driftwise::diagnosis {

ErrorFigures figures_of(const Eigen::VectorXd& residuals) {
  return error_figures(std::span(residuals.data(), static_cast<std::size_t>(residuals.size())));
}

double u90_of(const Eigen::VectorXd& residuals) {
  return residuals.size() < 2 ? NAN : figures_of(residuals).u90;
}

}  // namespace driftwise::diagnosis
