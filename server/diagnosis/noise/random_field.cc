#include "server/diagnosis/noise/random_field.h"

#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>

namespace driftwise::diagnosis {
namespace {

constexpr std::array<double, 6> kFieldOverNoise = {0.03, 0.1, 0.3, 1, 3, 10};
constexpr float kLeastShare = 1e-6F;  // of a series' sum of squares, left by a field
constexpr int kClippings = 2;

}  // namespace

RandomField::RandomField(const Timeline& timeline, const std::vector<NoiseShape>& shapes,
                         const SoftBase& base, double clip)
    : clip_(clip), spreads_(timeline.spreads()) {
  const SoftBase independent = independent_base(base);
  spaces_.reserve(shapes.size() * static_cast<std::size_t>(spreads_));
  for (const auto& shape : shapes)
    for (Eigen::Index g = 0; g < spreads_; ++g)
      spaces_.emplace_back(timeline, shape, independent, g);
}

RandomField::Seen RandomField::see(const std::vector<Eigen::MatrixXd>& outputs) const {
  const Eigen::Index rows = outputs.front().rows(), series = outputs.front().cols();
  Seen seen;
  seen.series = series;
  Eigen::MatrixXd all(rows, series * static_cast<Eigen::Index>(outputs.size()));
  for (std::size_t o = 0; o < outputs.size(); ++o)
    all.middleCols(static_cast<Eigen::Index>(o) * series, series) = outputs[o];
  Eigen::ArrayXd without = Eigen::ArrayXd::Constant(all.cols(), INFINITY);
  // Columns of the outputs whose rows are spread alike.
  const Eigen::Index together = all.cols() / spreads_;
  for (std::size_t s = 0; s * static_cast<std::size_t>(spreads_) < spaces_.size(); ++s) {
    seen.projected.emplace_back(rows, all.cols());
    seen.behind.emplace_back(all.cols());
    for (Eigen::Index g = 0; g < spreads_; ++g) {
      const WhitenedSpace& here = space(s, g);
      Eigen::MatrixXd left = here.left_over(all.middleCols(g * together, together));
      for (int pass = 0; pass < kClippings; ++pass) {
        for (Eigen::Index k = 0; k < left.cols(); ++k) {
          const double most =
              clip_ * left.col(k).norm() / std::sqrt(static_cast<double>(left.rows()));
          left.col(k) = left.col(k).cwiseMax(-most).cwiseMin(most);
        }
        here.project(left);  // what was clipped is no part of the base either
      }
      for (Eigen::Index k = 0; k < left.cols(); ++k) {
        const double squares = left.col(k).squaredNorm();
        seen.behind.back()[g * together + k] = here.criterion(squares);
        left.col(k) /= std::sqrt(std::max(squares, 1e-300));
      }
      here.project(left);  // in place of every field's columns
      seen.projected.back().middleCols(g * together, together) = left.cast<float>();
    }
    without = without.min(seen.behind.back());
  }
  for (auto& behind : seen.behind) behind -= without;
  return seen;
}

namespace {

// Gram matrix of a field's columns as Q T Q' with T tridiagonal: I + c T is factored anew for each
// size of the field in a few operations per column.
class TridiagonalGram {
 public:
  explicit TridiagonalGram(const Eigen::MatrixXd& gram) {
    const Eigen::Tridiagonalization<Eigen::MatrixXd> reduced(gram);
    diagonal_ = reduced.diagonal();
    beside_ = reduced.subDiagonal();
    packed_ = reduced.packedMatrix().cast<float>();
    coefficients_ = reduced.householderCoefficients().cast<float>();
  }

  // along: columns x series; becomes Q' along, series x columns.
  Eigen::ArrayXXf turned(Eigen::MatrixXf along) const {
    if (along.rows() > 1)
      along.applyOnTheLeft(Eigen::householderSequence(packed_, coefficients_)
                               .setLength(along.rows() - 1)
                               .setShift(1)
                               .adjoint());
    return along.transpose();
  }
  // Share of each series that the field takes at size c: along' (I / c + Q T Q')^-1 along.
  // Returns the log determinant of I + c Q T Q'.
  double share(double c, const Eigen::ArrayXXf& turned, Eigen::ArrayXf& taken) const {
    double pivot = 1 + c * diagonal_[0], log_determinant = std::log(pivot);
    Eigen::ArrayXf rest = turned.col(0);
    taken = rest.square() * static_cast<float>(c / pivot);
    for (Eigen::Index j = 1; j < diagonal_.size(); ++j) {
      const double step = c * beside_[j - 1] / pivot;
      pivot = 1 + c * diagonal_[j] - step * c * beside_[j - 1];
      rest = turned.col(j) - static_cast<float>(step) * rest;
      taken += rest.square() * static_cast<float>(c / pivot);
      log_determinant += std::log(pivot);
    }
    return log_determinant;
  }

 private:
  Eigen::VectorXd diagonal_, beside_;
  Eigen::MatrixXf packed_;
  Eigen::VectorXf coefficients_;
};

}  // namespace

Eigen::MatrixXd RandomField::growth(const Eigen::MatrixXd& columns, const Seen& seen) const {
  const Eigen::Index count = seen.behind.front().size();
  const Eigen::Index together = count / spreads_;
  Eigen::ArrayXf most = Eigen::ArrayXf::Zero(count), taken(together), worse(together);
  Eigen::MatrixXd white;
  for (std::size_t s = 0; s < seen.projected.size(); ++s)
    for (Eigen::Index g = 0; g < spreads_; ++g) {
      const WhitenedSpace& here = space(s, g);
      white = columns;
      here.whiten(white);
      const TridiagonalGram gram(here.gram_beyond(white));
      const Eigen::ArrayXXf turned = gram.turned(
          white.cast<float>().transpose() * seen.projected[s].middleCols(g * together, together));
      const auto dof = static_cast<float>(here.dof());
      const Eigen::ArrayXf behind = seen.behind[s].segment(g * together, together).cast<float>();
      for (const double rho : kFieldOverNoise) {
        const auto log_determinant = static_cast<float>(
            gram.share(rho / static_cast<double>(columns.cols()), turned, taken));
        worse = behind + dof * (1 - taken).max(kLeastShare).log() + log_determinant;
        auto here_most = most.segment(g * together, together);
        here_most = here_most.max(-worse);
      }
    }
  return most.matrix().cast<double>().reshaped(seen.series, count / seen.series).transpose();
}

}  // namespace driftwise::diagnosis
