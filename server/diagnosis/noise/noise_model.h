#pragma once
// The noise of a discrepancy: exponentially correlated (an Ornstein-Uhlenbeck process) plus white,
// starting afresh where a run or a datum begins. Two numbers, a physical shape: it can neither
// oscillate nor alternate, so it cannot swallow an effect as a free autoregression does
// (NUMERICS.md section 3).
//
// As a state-space model its whitening is one pass of a Kalman filter, linear in the data, with
// gains that depend on the instants only: unequal steps need no care, n rows cost n.

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

namespace driftwise::diagnosis {

struct NoiseShape {
  // Variance of the correlated part over that of the white one: of an instant over a row's.
  double slow_ratio = 0;
  double tau_s = 1;  // its correlation time
  bool operator==(const NoiseShape&) const = default;
};

// When each row was measured, where the noise starts afresh, and how large it is there.
struct Timeline {
  Eigen::VectorXd time_s;     // not decreasing within a stretch
  std::vector<char> restart;  // one per row; the first is 1
  // Spread of each row's noise over the others': one column for all outputs, or one for each of
  // them; empty: all alike.
  Eigen::MatrixXd sd;
  // Rows that are means of several readings, evenly over some time: how many, and from the first
  // to the last. Empty: of one each. A mean of correlated noise hangs together with the next more
  // than an instant does, and is itself calmer.
  Eigen::VectorXd readings = {}, span_s = {};
  Eigen::Index rows() const { return time_s.size(); }
  // Columns of the spread; all rows alike are one.
  Eigen::Index spreads() const { return std::max<Eigen::Index>(sd.cols(), 1); }
  // With one spread for what several outputs make up together: root mean square over them.
  Timeline with_one_spread() const;
  // The column of an output.
  Eigen::Index spread_of(Eigen::Index output) const { return sd.cols() > 1 ? output : 0; }
};

class Whitener {
 public:
  // output: whose spread it is.
  Whitener(const Timeline& timeline, NoiseShape shape, Eigen::Index output = 0);
  // Each column becomes its innovations over their standard deviation, in units of the white
  // part's.
  void apply(Eigen::Ref<Eigen::MatrixXd> columns) const;
  // The other way: independent standard normal numbers become such noise.
  void colour(Eigen::Ref<Eigen::VectorXd> innovations) const;
  double log_determinant() const { return log_determinant_; }  // of the covariance, white part 1

 private:
  template <int columns_at_once>
  void run(double* first, Eigen::Index stride) const;

  Eigen::VectorXd decay_, gain_, inverse_sd_, weight_;
  double log_determinant_ = 0;
};

// What a fit of the noise chooses from: no correlation, or ratio x correlation time, the times
// between one and a half typical steps and a quarter of the data's length.
std::vector<NoiseShape> noise_grid(const Timeline& timeline);

// Several series at once, rows x n, white standard deviation 1; mixing: n x n, how the series'
// random numbers hang together (mixing mixing' is their correlation).
Eigen::MatrixXd simulated_noise(const Timeline& timeline, const std::vector<NoiseShape>& shapes,
                                const Eigen::MatrixXd& mixing, std::mt19937_64& random);

}  // namespace driftwise::diagnosis
