#include "server/diagnosis/noise/random_field.h"

#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>

namespace driftwise::diagnosis {
namespace {

constexpr std::array<double, 6> kFieldOverNoise = {0.03, 0.1, 0.3, 1, 3, 10};
constexpr double kLeastEigenvalue = 1e-9;  // of the largest
constexpr double kLeastSquares = 1e-12;    // of a series' sum of squares
constexpr int kClippings = 2;

}  // namespace

RandomField::RandomField(const Timeline& timeline, const std::vector<NoiseShape>& shapes,
                         const SoftBase& base, double clip)
    : clip_(clip) {
  const SoftBase independent = independent_base(base);
  spaces_.reserve(shapes.size());
  for (const auto& shape : shapes) spaces_.emplace_back(timeline, shape, independent);
}

RandomField::Seen RandomField::see(const Eigen::MatrixXd& series) const {
  Seen seen;
  seen.squares.resize(static_cast<Eigen::Index>(spaces_.size()), series.cols());
  seen.without = Eigen::ArrayXd::Constant(series.cols(), INFINITY);
  for (std::size_t s = 0; s < spaces_.size(); ++s) {
    Eigen::MatrixXd left = spaces_[s].left_over(series);
    for (int pass = 0; pass < kClippings; ++pass) {
      for (Eigen::Index k = 0; k < left.cols(); ++k) {
        const double most =
            clip_ * left.col(k).norm() / std::sqrt(static_cast<double>(left.rows()));
        left.col(k) = left.col(k).cwiseMax(-most).cwiseMin(most);
      }
      spaces_[s].project(left);  // what was clipped is no part of the base either
    }
    const auto row = static_cast<Eigen::Index>(s);
    seen.squares.row(row) = left.colwise().squaredNorm();
    for (Eigen::Index k = 0; k < left.cols(); ++k)
      seen.without[k] = std::min(seen.without[k], spaces_[s].criterion(seen.squares(row, k)));
    seen.left.push_back(std::move(left));
  }
  return seen;
}

Eigen::MatrixXd RandomField::growth(const Eigen::MatrixXd& columns,
                                    const std::vector<Seen>& outputs) const {
  const auto count = static_cast<Eigen::Index>(outputs.size());
  Eigen::MatrixXd growth = Eigen::MatrixXd::Zero(count, outputs.front().without.size());
  for (std::size_t s = 0; s < spaces_.size(); ++s) {
    const Eigen::MatrixXd white = spaces_[s].left_over(columns);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(white.transpose() * white);
    const double largest = eigen.eigenvalues().tail(1)[0];
    if (!(largest > 0)) continue;
    const Eigen::Index none = (eigen.eigenvalues().array() < kLeastEigenvalue * largest).count();
    const Eigen::ArrayXd values = eigen.eigenvalues().tail(columns.cols() - none);
    const Eigen::MatrixXd turn = eigen.eigenvectors().rightCols(values.size());
    for (std::size_t o = 0; o < outputs.size(); ++o) {
      const Eigen::MatrixXd along =
          (turn.transpose() * (white.transpose() * outputs[o].left[s])).array().square();
      for (const double rho : kFieldOverNoise) {
        const double per_column = rho / static_cast<double>(columns.cols());
        const Eigen::ArrayXd more = 1 + per_column * values;
        const Eigen::RowVectorXd taken = (per_column / more).matrix().transpose() * along;
        const double log_determinant = more.log().sum();
        for (Eigen::Index k = 0; k < taken.size(); ++k) {
          const double all = outputs[o].squares(static_cast<Eigen::Index>(s), k);
          const double with =
              spaces_[s].criterion(std::max(all - taken[k], kLeastSquares * all)) + log_determinant;
          auto& most = growth(static_cast<Eigen::Index>(o), k);
          most = std::max(most, outputs[o].without[k] - with);
        }
      }
    }
  }
  return growth;
}

}  // namespace driftwise::diagnosis
