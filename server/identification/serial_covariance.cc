#include "server/identification/serial_covariance.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "server/calibration/noise/noise_spectrum.h"

namespace driftwise::identification {
namespace {

using Eigen::Index;

constexpr Index kAllRows = 2048, kMostStretches = 16, kStretchRows = 1024;
constexpr double kFewestFreedom =
    4;  // of one output: below, its residuals say no size of their own

// Orthonormal columns over one output's rows: those directions of `q` (its rows of columns that are
// orthonormal over all outputs) that the fit took most of, as many as it took in sum.
Eigen::MatrixXd directions_taken(const Eigen::Ref<const Eigen::MatrixXd>& q) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(q.transpose() * q);
  const Index taken = std::lround(eigen.eigenvalues().sum());
  return q * eigen.eigenvectors().rightCols(taken) *
         eigen.eigenvalues().tail(taken).cwiseSqrt().cwiseInverse().asDiagonal();
}

// The noise of one output; pooled: the variance of a row over all of them.
calibration::NoiseSpectrum noise_of(const Eigen::Ref<const Eigen::MatrixXd>& q,
                                    const Eigen::Ref<const Eigen::VectorXd>& residuals,
                                    double pooled) {
  const Index rows = residuals.size();
  const double freedom = static_cast<double>(rows) - q.squaredNorm();
  if (freedom < kFewestFreedom || !(residuals.squaredNorm() > 0)) return {pooled, {}};
  if (rows <= kAllRows) {
    const Eigen::MatrixXd taken = directions_taken(q);
    auto noise = calibration::noise_spectrum(taken, residuals, rows);
    // Correction for the rounded count of directions.
    const double factor = static_cast<double>(rows - taken.cols()) / freedom;
    noise.white *= factor;
    for (auto& part : noise.slow) part.variance *= factor;
    return noise;
  }
  const Index count = std::min(kMostStretches, rows / kStretchRows);
  Eigen::VectorXd series(count * kStretchRows);
  for (Index i = 0; i < count; ++i)
    series.segment(i * kStretchRows, kStretchRows) =
        residuals.segment((rows - kStretchRows) * i / (count - 1), kStretchRows);
  return calibration::noise_spectrum(Eigen::MatrixXd(series.size(), 0), series, kStretchRows);
}

}  // namespace

Eigen::MatrixXd serial_covariance(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residuals,
                                  Index outputs) {
  const Index unknowns = jacobian.cols(), rows = jacobian.rows() / outputs;
  if (unknowns == 0) return {};
  const Eigen::VectorXd lengths = jacobian.colwise().norm();
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(jacobian * lengths.cwiseInverse().asDiagonal());
  const Eigen::MatrixXd triangle = qr.matrixQR().topRows(unknowns).triangularView<Eigen::Upper>();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(triangle, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::MatrixXd root = lengths.cwiseInverse().asDiagonal() * svd.matrixV() *
                               svd.singularValues().cwiseInverse().asDiagonal();
  const Eigen::MatrixXd q =
      qr.householderQ() * Eigen::MatrixXd::Identity(jacobian.rows(), unknowns) * svd.matrixU();
  const double pooled = residuals.squaredNorm() /
                        std::max<double>(1, static_cast<double>(jacobian.rows() - unknowns));
  Eigen::MatrixXd noise = Eigen::MatrixXd::Zero(unknowns, unknowns);
  for (Index o = 0; o < outputs; ++o) {
    const auto of_output = q.middleRows(o * rows, rows);
    noise += calibration::noise_gram(
        of_output, noise_of(of_output, residuals.segment(o * rows, rows), pooled));
  }
  return root * noise * root.transpose();
}

}  // namespace driftwise::identification
