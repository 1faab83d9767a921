#include "server/calibration/noise/noise_spectrum.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <numeric>
#include <unsupported/Eigen/FFT>

namespace driftwise::calibration {
namespace {

using Eigen::Index;

constexpr Index kNoiseLengths = 8;
constexpr double kShortestRows = 0.7;      // rows: below, slow cannot be told from white
constexpr Index kShares = 8, kThirds = 7;  // steps of the parts' proportions
constexpr double kBandRatio = 1.25;

// White and every length: the proportions of one possible noise, of sum 1, with its prior.
struct PossibleNoise {
  std::array<double, kNoiseLengths + 1> part{};
  double prior = 0;
};

std::vector<PossibleNoise> make_possible_noises() {
  std::vector<PossibleNoise> out(1);
  out.front().part[0] = 1;
  out.front().prior = 1.0 / 3;
  for (std::size_t i = 1; i <= kNoiseLengths; ++i)
    for (Index s = 0; s < kShares; ++s) {
      const double angle =
          (static_cast<double>(s) + 0.5) / kShares * std::numbers::pi / 2;  // of the deviations
      auto& one = out.emplace_back();
      one.part[0] = std::pow(std::cos(angle), 2);
      one.part[i] = std::pow(std::sin(angle), 2);
      one.prior = 1.0 / 3 / (kNoiseLengths * kShares);
    }
  constexpr double kPairs =
      kNoiseLengths * (kNoiseLengths - 1) / 2.0 * (kThirds * (kThirds + 1) / 2.0);
  for (std::size_t i = 1; i <= kNoiseLengths; ++i)
    for (std::size_t j = i + 1; j <= kNoiseLengths; ++j)
      for (Index a = 0; a < kThirds; ++a)
        for (Index b = 0; a + b < kThirds; ++b) {
          const Eigen::Vector3d deviations(static_cast<double>(a) + 1.0 / 3,
                                           static_cast<double>(b) + 1.0 / 3,
                                           static_cast<double>(kThirds - 1 - a - b) + 1.0 / 3);
          const Eigen::Vector3d shares = deviations.cwiseAbs2() / deviations.squaredNorm();
          auto& one = out.emplace_back();
          one.part[0] = shares[0];
          one.part[i] = shares[1];
          one.part[j] = shares[2];
          one.prior = 1.0 / 3 / kPairs;
        }
  return out;
}

const std::vector<PossibleNoise>& possible_noises() {
  static const std::vector<PossibleNoise> all = make_possible_noises();
  return all;
}

// Frequencies that count alike: begin of each band, and the end.
std::vector<Index> frequency_bands(Index frequencies) {
  std::vector<Index> edges = {0};
  while (edges.back() < frequencies)
    edges.push_back(std::min(
        frequencies,
        std::max(edges.back() + 1,
                 static_cast<Index>(std::lround(kBandRatio * static_cast<double>(edges.back()))))));
  return edges;
}

// Orthonormal discrete cosine transform (II), by a Fourier transform of the same length (Makhoul
// 1980).
class Cosines {
 public:
  explicit Cosines(Index rows) : rows_(rows), shuffled_(static_cast<std::size_t>(rows)) {
    for (Index j = 0; j < rows; ++j)
      turn_.push_back(
          std::polar(std::sqrt((j == 0 ? 1.0 : 2.0) / static_cast<double>(rows)),
                     -std::numbers::pi * static_cast<double>(j) / (2 * static_cast<double>(rows))));
  }
  template <class Column>
  Eigen::VectorXd of(const Column& values) {
    for (Index i = 0; i < rows_; ++i)
      shuffled_[static_cast<std::size_t>(i % 2 == 0 ? i / 2 : rows_ - 1 - i / 2)] = values[i];
    fourier_.fwd(spectrum_, shuffled_);
    Eigen::VectorXd out(rows_);
    for (Index j = 0; j < rows_; ++j) {
      const auto at = static_cast<std::size_t>(j);
      out[j] = (spectrum_[at] * turn_[at]).real();
    }
    return out;
  }

 private:
  Index rows_;
  std::vector<double> shuffled_;
  std::vector<std::complex<double>> turn_, spectrum_;
  Eigen::FFT<double> fourier_;
};

// Products of the transformed [columns | residuals] with themselves, one column per band.
Eigen::MatrixXd products_by_band(const Eigen::Ref<const Eigen::MatrixXd>& columns,
                                 const Eigen::Ref<const Eigen::VectorXd>& residuals,
                                 Index stretch_rows, const std::vector<Index>& edges) {
  const Index k = columns.cols() + 1, bands = static_cast<Index>(edges.size()) - 1;
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(k * k, bands);
  Eigen::MatrixXd transformed(stretch_rows, k);
  Cosines cosines(stretch_rows);
  for (Index begin = 0; begin + stretch_rows <= residuals.size(); begin += stretch_rows) {
    for (Index c = 0; c + 1 < k; ++c)
      transformed.col(c) = cosines.of(columns.col(c).segment(begin, stretch_rows));
    transformed.col(k - 1) = cosines.of(residuals.segment(begin, stretch_rows));
    for (Index b = 0; b < bands; ++b) {
      const Index first = edges[static_cast<std::size_t>(b)],
                  rows = edges[static_cast<std::size_t>(b) + 1] - first;
      const auto part = transformed.middleRows(first, rows);
      Eigen::Map<Eigen::MatrixXd>(out.col(b).data(), k, k) += part.transpose() * part;
    }
  }
  return out;
}

// -2 x restricted log likelihood at the best variance, up to a constant, and the sum of squares in
// units of the noise. products: of [columns | residuals] under it.
struct NoiseLook {
  double deviance = std::numeric_limits<double>::infinity(), squares = 0;
};
NoiseLook look_at_noise(const Eigen::MatrixXd& products, double log_determinant, double dof) {
  const Index k = products.rows() - 1;
  double squares = products(k, k);
  if (k > 0) {
    const Eigen::LLT<Eigen::MatrixXd> factor(products.topLeftCorner(k, k));
    if (factor.info() != Eigen::Success) return {};
    const Eigen::VectorXd along = factor.matrixL().solve(products.col(k).head(k));
    squares -= along.squaredNorm();
    log_determinant += 2 * factor.matrixLLT().diagonal().array().log().sum();
  }
  if (!(squares > 0)) return {};
  return {dof * std::log(squares) + log_determinant, squares};
}

}  // namespace

double NoiseSpectrum::variance() const {
  return std::accumulate(slow.begin(), slow.end(), white,
                         [](double sum, const Slow& part) { return sum + part.variance; });
}

double cosine_variance(double phi, Index rows, Index frequency) {
  // sum over i of phi^|i - m| cos(w (i + 1/2)) is the cosine times the spectrum, less what is
  // missing beyond either end: phi^m and phi^(rows - 1 - m) with the amplitude below.
  const auto n = static_cast<double>(rows);
  const double w = std::numbers::pi * static_cast<double>(frequency) / n;
  const double q = std::pow(1 - phi, 2) + 4 * phi * std::pow(std::sin(w / 2), 2);
  const double end = (1 - phi) * std::cos(w / 2) / q;
  const double other_end = (frequency % 2 == 0 ? 1 : -1) * std::pow(phi, n);
  return (1 - phi * phi) / q - (frequency == 0 ? 2 : 4) / n * phi * (1 - other_end) * end * end;
}

NoiseSpectrum noise_spectrum(const Eigen::Ref<const Eigen::MatrixXd>& columns,
                             const Eigen::Ref<const Eigen::VectorXd>& residuals,
                             Index stretch_rows) {
  NoiseSpectrum noise;
  const Index k = columns.cols() + 1;
  const double dof = static_cast<double>(residuals.size() - columns.cols());
  noise.white = dof > 0 ? residuals.squaredNorm() / dof : 0;
  if (dof < 4) return noise;

  const auto edges = frequency_bands(stretch_rows);
  const Index bands = static_cast<Index>(edges.size()) - 1;
  const Eigen::MatrixXd products = products_by_band(columns, residuals, stretch_rows, edges);
  const double stretches = static_cast<double>(residuals.size() / stretch_rows);
  const double longest = std::max(kShortestRows + 0.1, static_cast<double>(stretch_rows) / 2);
  Eigen::MatrixXd variances = Eigen::MatrixXd::Ones(bands, kNoiseLengths + 1);  // of band, by part
  Eigen::VectorXd counts(bands);
  for (Index i = 0; i < kNoiseLengths; ++i)
    noise.slow.push_back({kShortestRows * std::pow(longest / kShortestRows,
                                                   static_cast<double>(i) / (kNoiseLengths - 1)),
                          0});
  for (Index b = 0; b < bands; ++b) {
    const Index first = edges[static_cast<std::size_t>(b)],
                end = edges[static_cast<std::size_t>(b) + 1];
    counts[b] = stretches * static_cast<double>(end - first);
    for (Index i = 0; i < kNoiseLengths; ++i) {
      const double phi = std::exp(-1 / noise.slow[static_cast<std::size_t>(i)].rows);
      double sum = 0;
      for (Index j = first; j < end; ++j) sum += cosine_variance(phi, stretch_rows, j);
      variances(b, i + 1) = sum / static_cast<double>(end - first);
    }
  }

  const auto& all = possible_noises();
  std::vector<NoiseLook> looks;
  double best = std::numeric_limits<double>::infinity();
  Eigen::MatrixXd sum(k, k);
  for (const auto& one : all) {
    const Eigen::VectorXd of_band =
        variances * Eigen::Map<const Eigen::VectorXd>(one.part.data(), kNoiseLengths + 1);
    Eigen::Map<Eigen::VectorXd>(sum.data(), k * k) = products * of_band.cwiseInverse();
    looks.push_back(look_at_noise(sum, counts.dot(of_band.array().log().matrix()), dof));
    looks.back().deviance -= 2 * std::log(one.prior);
    best = std::min(best, looks.back().deviance);
  }
  if (!std::isfinite(best)) return noise;

  double total = 0, white = 0;
  for (std::size_t c = 0; c < all.size(); ++c) {
    const double weight = std::exp((best - looks[c].deviance) / 2);
    if (!(weight > 0)) continue;
    total += weight;
    const double variance = weight * looks[c].squares / (dof - 2);
    white += variance * all[c].part[0];
    for (std::size_t i = 0; i < kNoiseLengths; ++i)
      noise.slow[i].variance += variance * all[c].part[i + 1];
  }
  noise.white = white / total;
  for (auto& part : noise.slow) part.variance /= total;
  return noise;
}

Eigen::MatrixXd noise_gram(const Eigen::Ref<const Eigen::MatrixXd>& columns,
                           const NoiseSpectrum& noise) {
  const Eigen::MatrixXd across = columns.transpose();
  // remembered: sum over earlier rows of their covariance with the row. One product with it serves
  // all parts.
  Eigen::MatrixXd remembered = Eigen::MatrixXd::Zero(across.rows(), across.cols());
  for (const auto& part : noise.slow) {
    if (!(part.variance > 0)) continue;
    const double phi = std::exp(-1 / part.rows);
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(across.rows());
    for (Index t = 0; t < across.cols(); ++t) {
      remembered.col(t) += sum;
      sum += part.variance * across.col(t);
      sum *= phi;
    }
  }
  const Eigen::MatrixXd half = across * remembered.transpose();
  return noise.variance() * (across * columns) + half + half.transpose();
}

}  // namespace driftwise::calibration
