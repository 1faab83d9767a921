#include "server/calibration/linear/triangle.h"

#include <algorithm>

namespace driftwise::calibration {

Triangle make_triangle(Eigen::MatrixXd joint, const Eigen::VectorXd& means, const Basis& basis,
                       Eigen::Index outputs, std::int64_t rows) {
  // [1 | M] = [1 | M - mean] S with S = 1 but for its first row; the constant's column has one
  // entry.
  if (joint.rows() > 0) joint.row(0) += joint(0, 0) * means.transpose();
  const auto m = static_cast<Eigen::Index>(basis.monomials.size());
  const Eigen::Index r = std::min(joint.rows(), m);
  Triangle triangle;
  triangle.rows = rows;
  triangle.monomials = joint.topLeftCorner(r, m);
  triangle.outputs = joint.block(0, m, r, outputs);
  triangle.beyond.resize(outputs);
  for (Eigen::Index o = 0; o < outputs; ++o)
    triangle.beyond[o] = joint.col(m + o).tail(joint.rows() - r).squaredNorm();
  triangle.columns.resize(r, static_cast<Eigen::Index>(basis.expansions.size()));
  for (std::size_t j = 0; j < basis.expansions.size(); ++j) {
    const auto& parts = basis.expansions[j].parts;
    const Eigen::Index depth = std::min<Eigen::Index>(r, parts.back().first + 1);
    auto column = triangle.columns.col(static_cast<Eigen::Index>(j));
    column.setZero();
    // Extended precision: the parts of a raw power far from zero cancel.
    for (Eigen::Index i = 0; i < depth; ++i) {
      long double sum = 0;
      for (const auto& [monomial, value] : parts) sum += value * triangle.monomials(i, monomial);
      column[i] = static_cast<double>(sum);
    }
  }
  return triangle;
}

}  // namespace driftwise::calibration
