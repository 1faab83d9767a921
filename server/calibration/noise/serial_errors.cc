#include "server/calibration/noise/serial_errors.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "server/calibration/noise/noise_spectrum.h"

namespace driftwise::calibration {
namespace {

using Eigen::Index;

constexpr Index kAllRows = 2048, kMostStretches = 16, kStretchRows = 1024;

struct Stretch {
  Index begin, rows;
};

std::vector<Stretch> stretches_of(Index rows) {
  if (rows <= kAllRows) return {{0, rows}};
  const Index count = std::min(kMostStretches, rows / kStretchRows);
  std::vector<Stretch> stretches;
  for (Index i = 0; i < count; ++i)
    stretches.push_back({(rows - kStretchRows) * i / (count - 1), kStretchRows});
  return stretches;
}

// The columns in, orthonormal over all rows.
Eigen::MatrixXd orthonormal(const Design& design, const Solution& solution,
                            const Stretch& stretch) {
  const Index m = design.monomials();
  const Eigen::MatrixXd weights = solution.shape * solution.to_orthonormal;
  const Eigen::MatrixXd block = design.block(stretch.begin, stretch.rows);
  // The matrix stands about its means; its first column is the root of the weights.
  return block.leftCols(m) * weights +
         block.col(0) * (design.columns.means().head(m).transpose() * weights);
}

Eigen::VectorXd times_root_of_weights(const Design& design, Eigen::VectorXd residuals) {
  if (!design.weighted) return residuals;
  for (Index row = 0; row < residuals.size(); ++row)
    residuals[row] *= std::sqrt(design.columns.weight(design.rows[static_cast<std::size_t>(row)]));
  return residuals;
}

// L with L L' = the matrix, which is positive but for rounding.
Eigen::MatrixXd root_of(const Eigen::MatrixXd& matrix) {
  const Eigen::LLT<Eigen::MatrixXd> cholesky(matrix);
  if (cholesky.info() == Eigen::Success) return cholesky.matrixL();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(matrix);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
}

// The residuals of several stretches, one after another.
Eigen::VectorXd joined(const Eigen::VectorXd& residuals, const std::vector<Stretch>& stretches) {
  Eigen::VectorXd series(static_cast<Index>(stretches.size()) * stretches.front().rows);
  Index at = 0;
  for (const auto& stretch : stretches) {
    series.segment(at, stretch.rows) = residuals.segment(stretch.begin, stretch.rows);
    at += stretch.rows;
  }
  return series;
}

}  // namespace

SerialErrors serial_errors(const Design& design, const Solution& solution,
                           const Eigen::VectorXd& residuals) {
  SerialErrors errors;
  const Index k = solution.root.rows();
  errors.standard_errors = Eigen::VectorXd::Zero(k);
  if (solution.dof < 1 || k == 0) return errors;
  const Eigen::VectorXd scaled = times_root_of_weights(design, residuals);
  const auto stretches = stretches_of(scaled.size());
  Eigen::MatrixXd together = Eigen::MatrixXd::Zero(k, k), apart = together;
  for (const auto& stretch : stretches) {
    const Eigen::MatrixXd z = orthonormal(design, solution, stretch);
    if (&stretch == &stretches.front()) {
      // Of stretches as one series: far apart as they are, the few pairs across their borders do
      // no harm.
      const bool whole = stretches.size() == 1;
      const Eigen::VectorXd series = whole ? scaled : joined(scaled, stretches);
      const Eigen::MatrixXd columns = whole ? z : Eigen::MatrixXd(series.size(), 0);
      errors.noise = serial_noise(columns, series);
      errors.spectrum = noise_spectrum(columns, series, stretch.rows);
    }
    together += noise_gram(z, errors.spectrum);
    apart += z.transpose() * z;
  }
  for (Index j = 0; j < k; ++j) {
    const auto row = solution.root.row(j);
    const double plain = row * apart * row.transpose();
    const double ratio =
        plain > 0 ? (row * together * row.transpose()).value() / plain : errors.spectrum.variance();
    errors.standard_errors[j] = std::sqrt(row.squaredNorm() * std::max(ratio, 0.0));
  }
  if (stretches.size() == 1) {
    errors.covariance = solution.root * together * solution.root.transpose();
    errors.root = solution.root * root_of(together);
  } else {
    const Eigen::MatrixXd classical = solution.root * solution.root.transpose();
    const Eigen::VectorXd factor =
        errors.standard_errors.cwiseQuotient(classical.diagonal().cwiseSqrt());
    errors.covariance = factor.asDiagonal() * classical * factor.asDiagonal();
    errors.root = factor.asDiagonal() * solution.root;
  }
  return errors;
}

}  // namespace driftwise::calibration
