#pragma once
// Variance of the residuals' noise by correlation length, as the residuals leave it possible.
//
// covariance(i, j) = white (i = j) + sum over the slow parts of variance * exp(-|i - j| / rows).
// Rows count as equally spaced. The lengths are a fixed ladder from 0.7 rows to half the series.
//
// A campaign is a few lengths of its slowest noise long. The best single slow part (serial_noise.h)
// follows the noise that most rows speak of, the fast one, and says nothing of a slower one below
// it, which is what slow terms take up. So no one noise is chosen: the variances are expectations
// over white noise, white and one slow part, white and two, a third of the prior each; lengths
// uniform on the ladder; the parts' standard deviations in any proportion, uniform in direction;
// the whole variance unknown (uniform in its logarithm). The restricted likelihood (Harville 1974)
// gives back what the fitted terms took out of the residuals.
//
// The likelihood is that of the discrete cosine transform of columns and residuals, in which noise
// of exponential correlation is nearly independent (Ahmed, Natarajan and Rao 1974); frequencies of
// one band count alike. Measured against the whole matrix: noise_spectrum_test.cc.

#include <Eigen/Core>
#include <vector>

namespace driftwise::calibration {

struct NoiseSpectrum {
  struct Slow {
    double rows = 0;  // correlation length
    double variance = 0;
  };
  double white = 0;  // variance of one row
  std::vector<Slow> slow;
  double variance() const;  // of one row, all parts
};

// columns: rows x terms, what was fitted, of full rank; may have no columns. residuals: about
// those columns, in time order. stretch_rows: length of the stretches that follow one another in
// the rows, far apart in time; all rows for one series. Too few rows: white.
// Cost: one transform per column, 849 Cholesky factors of terms x terms.
NoiseSpectrum noise_spectrum(const Eigen::Ref<const Eigen::MatrixXd>& columns,
                             const Eigen::Ref<const Eigen::VectorXd>& residuals,
                             Eigen::Index stretch_rows);

// columns' C columns with C the covariance of the noise.
Eigen::MatrixXd noise_gram(const Eigen::Ref<const Eigen::MatrixXd>& columns,
                           const NoiseSpectrum& noise);

// Variance of coefficient `frequency` of the orthonormal discrete cosine transform of so many rows
// of noise with variance 1 and correlation phi^|i - j|, 0 <= phi < 1.
double cosine_variance(double phi, Eigen::Index rows, Eigen::Index frequency);

}  // namespace driftwise::calibration
