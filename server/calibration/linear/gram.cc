#include "server/calibration/linear/gram.h"

#include <algorithm>
#include <cmath>

namespace driftwise::calibration {

using Eigen::Index;

GramTriangle gram_triangle(const Eigen::MatrixXd& gram, Index columns) {
  GramTriangle result;
  const Index width = gram.cols();
  Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(width, width);
  for (Index j = 0; j < columns; ++j) {
    const Index below = width - j;
    Eigen::VectorXd column = gram.col(j).tail(below);
    column.noalias() -= lower.bottomLeftCorner(below, j) * lower.row(j).head(j).transpose();
    const double pivot = gram(j, j) > 0 ? column[0] / gram(j, j) : 0;
    if (j == 0 || pivot < result.worst_pivot) {
      result.worst = j;
      result.worst_pivot = pivot;
    }
    if (!(pivot > kSafePivot)) return result;
    lower.col(j).tail(below) = column / std::sqrt(column[0]);
  }
  for (Index o = columns; o < width; ++o) {
    const double left = gram(o, o) - lower.row(o).head(columns).squaredNorm();
    lower(o, o) = std::sqrt(std::max(left, 0.0));
  }
  result.joint = lower.transpose();
  return result;
}

}  // namespace driftwise::calibration
