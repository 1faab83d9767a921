#include "server/calibration/noise/serial_noise.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace driftwise::calibration {
namespace {

using Eigen::Index;

constexpr double kShortest = 0.7;  // rows: below, slow cannot be told from white
// Fall of -2 ln L that two parameters more have to be worth (AIC); else the noise is called white.
constexpr double kWorthAParameter = 4;

double phi_of(double rows) { return rows > 0 ? std::exp(-1 / rows) : 0; }

// The innovations of every column of [columns | residuals] under a noise of variance 1, each over
// its standard deviation: white, where the noise is what it is said to be.
class Whitener {
 public:
  Whitener(const Eigen::Ref<const Eigen::MatrixXd>& columns,
           const Eigen::Ref<const Eigen::VectorXd>& residuals)
      : raw_(columns.cols() + 1, columns.rows()), white_(raw_.rows(), raw_.cols()) {
    raw_.topRows(columns.cols()) = columns.transpose();
    raw_.bottomRows(1) = residuals.transpose();
  }

  // -2 x restricted log likelihood, up to a constant, the variance at its best.
  double deviance(double share, double rows) {
    const double phi = phi_of(rows), drive = share * (1 - phi * phi);
    Eigen::VectorXd predicted = Eigen::VectorXd::Zero(raw_.rows());
    double uncertain = share;  // variance of the slow part before the row is seen
    double log_determinant = 0;
    for (Index t = 0; t < raw_.cols(); ++t) {
      const double f = uncertain + 1 - share + kLeast, gain = uncertain / f;
      log_determinant += std::log(f);
      white_.col(t) = (raw_.col(t) - predicted) / std::sqrt(f);
      predicted = phi * (predicted + gain * (raw_.col(t) - predicted));
      uncertain = phi * phi * uncertain * (1 - gain) + drive;
    }
    const Index k = raw_.rows() - 1;
    const auto n = static_cast<double>(raw_.cols()), dof = n - static_cast<double>(k);
    double squares = white_.bottomRows(1).squaredNorm();
    if (k > 0) {
      Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(k, k);
      gram.selfadjointView<Eigen::Lower>().rankUpdate(white_.topRows(k));
      const Eigen::LLT<Eigen::MatrixXd> factor(gram);
      if (factor.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
      const Eigen::VectorXd along =
          factor.matrixL().solve(white_.topRows(k) * white_.bottomRows(1).transpose());
      squares -= along.squaredNorm();
      for (Index i = 0; i < k; ++i) log_determinant += 2 * std::log(factor.matrixLLT()(i, i));
    }
    variance_ = squares / dof;
    if (!(squares > 0)) return std::numeric_limits<double>::infinity();
    return dof * std::log(squares) + log_determinant;
  }
  double variance() const { return variance_; }  // of the last deviance()

 private:
  static constexpr double kLeast = 1e-12;  // keeps a purely slow noise from a determinant of 0
  Eigen::MatrixXd raw_, white_;            // one column per row of data
  double variance_ = 0;
};

using Point = Eigen::Vector2d;

// Downhill simplex (Nelder and Mead 1965) with a fixed number of looks: share and length trade
// against each other along a curved valley, where steps along one at a time get nowhere.
template <class F>
void simplex(F f, const Point& start, const Point& size, int looks) {
  struct Corner {
    Point at;
    double value;
  };
  const auto look = [&](const Point& at) {
    --looks;
    return Corner{at, f(at)};
  };
  std::array<Corner, 3> corners = {look(start), look(start + Point(size[0], 0)),
                                   look(start + Point(0, size[1]))};
  while (looks > 0) {
    std::ranges::stable_sort(corners, {}, &Corner::value);
    const Point middle = (corners[0].at + corners[1].at) / 2, away = middle - corners[2].at;
    const Corner mirrored = look(middle + away);
    if (mirrored.value < corners[0].value) {
      const Corner further = look(middle + 2 * away);
      corners[2] = further.value < mirrored.value ? further : mirrored;
    } else if (mirrored.value < corners[1].value) {
      corners[2] = mirrored;
    } else {
      const bool outside = mirrored.value < corners[2].value;
      const Corner nearer = look(middle + (outside ? 0.5 : -0.5) * away);
      if (nearer.value < std::min(mirrored.value, corners[2].value)) {
        corners[2] = nearer;
      } else {
        corners[1] = look((corners[0].at + corners[1].at) / 2);
        corners[2] = look((corners[0].at + corners[2].at) / 2);
      }
    }
  }
}

}  // namespace

double SerialNoise::phi() const { return phi_of(rows); }

SerialNoise serial_noise(const Eigen::Ref<const Eigen::MatrixXd>& columns,
                         const Eigen::Ref<const Eigen::VectorXd>& residuals) {
  SerialNoise noise;
  const auto n = static_cast<double>(residuals.size());
  if (residuals.size() <= columns.cols() + 3) {
    const double dof = n - static_cast<double>(columns.cols());
    noise.variance = dof > 0 ? residuals.squaredNorm() / dof : 0;
    return noise;
  }
  Whitener whitener(columns, residuals);
  const double white = whitener.deviance(0, 1);
  double best = white;
  noise.variance = whitener.variance();
  double log_rows = 0, share = 0;
  const auto look = [&](double one_share, double one_log_rows) {
    const double deviance = whitener.deviance(one_share, std::exp(one_log_rows));
    if (deviance < best - 1e-9) {
      best = deviance;
      share = one_share;
      log_rows = one_log_rows;
      noise.variance = whitener.variance();
    }
    return deviance;
  };
  const double shortest = std::log(kShortest), longest = std::log(std::max(1.0, n / 2));
  constexpr int kLengths = 8;
  constexpr std::array<double, 4> kShares = {0.15, 0.4, 0.7, 0.95};
  const double step = (longest - shortest) / (kLengths - 1);
  for (int i = 0; i < kLengths; ++i)
    for (const double one : kShares) look(one, shortest + step * i);
  if (share > 0)
    simplex(
        [&](const Point& at) {  // beyond the edges the edge counts
          return look(std::clamp(at[0], 0.0, 1.0), std::clamp(at[1], shortest, longest));
        },
        {share, log_rows}, {share > 0.5 ? -0.2 : 0.2, step / 2}, 50);
  if (best > white - kWorthAParameter) {
    whitener.deviance(0, 1);
    noise.variance = whitener.variance();
    return noise;
  }
  noise.share = share;
  noise.rows = share > 0 ? std::exp(log_rows) : 0;
  return noise;
}

double serial_deviance(const Eigen::Ref<const Eigen::MatrixXd>& columns,
                       const Eigen::Ref<const Eigen::VectorXd>& residuals, double share,
                       double correlation_rows) {
  return Whitener(columns, residuals).deviance(share, correlation_rows);
}

Eigen::MatrixXd correlated_gram(const Eigen::Ref<const Eigen::MatrixXd>& columns,
                                const SerialNoise& noise) {
  const Eigen::MatrixXd across = columns.transpose();
  Eigen::MatrixXd gram = across * columns;
  if (!(noise.share > 0)) return gram;
  // remembered: sum over earlier rows of phi^distance * row.
  Eigen::MatrixXd remembered(across.rows(), across.cols());
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(across.rows());
  for (Index t = 0; t < across.cols(); ++t) {
    remembered.col(t) = sum;
    sum = noise.phi() * (sum + across.col(t));
  }
  const Eigen::MatrixXd half = noise.share * (across * remembered.transpose());
  return gram + half + half.transpose();
}

}  // namespace driftwise::calibration
