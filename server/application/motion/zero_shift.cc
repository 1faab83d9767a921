#include "server/application/motion/zero_shift.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>

namespace driftwise::application {

void add_closure(Closures& closures, const std::vector<double>& warming_k,
                 std::span<const double> closure_nm) {
  closures.resize(std::max(closures.size(), closure_nm.size()));
  for (std::size_t i = 0; i < closure_nm.size(); ++i)
    if (!std::isnan(closure_nm[i])) closures[i].push_back({warming_k, closure_nm[i]});
}

ZeroPrediction predict_zero_shift(std::span<const ZeroObservation> observations,
                                  std::span<const double> warming_k) {
  const auto sensors = static_cast<Eigen::Index>(warming_k.size());
  const Eigen::Index columns = sensors + 1;  // the datum's own error first
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(columns, columns);
  information(0, 0) = 1 / (kDatumNoise_nm * kDatumNoise_nm);
  for (Eigen::Index i = 1; i < columns; ++i)
    information(i, i) = 1 / (kPriorNmPerKelvin * kPriorNmPerKelvin);
  Eigen::VectorXd weighted = Eigen::VectorXd::Zero(columns);
  const double weight = 1 / (kClosureNoise_nm * kClosureNoise_nm);
  std::size_t used = 0;
  for (const auto& seen : observations) {
    if (seen.warming_k.size() != warming_k.size()) continue;
    Eigen::VectorXd row(columns);
    row(0) = 1;
    for (Eigen::Index i = 0; i < sensors; ++i)
      row(i + 1) = seen.warming_k[static_cast<std::size_t>(i)];
    information.noalias() += weight * row * row.transpose();
    weighted.noalias() += weight * seen.closure_nm * row;
    ++used;
  }
  const Eigen::LDLT<Eigen::MatrixXd> solver(information);
  Eigen::VectorXd now(columns);
  now(0) = 1;
  for (Eigen::Index i = 0; i < sensors; ++i) now(i + 1) = warming_k[static_cast<std::size_t>(i)];
  const Eigen::VectorXd coefficients = solver.solve(weighted);
  const Eigen::VectorXd spread = solver.solve(now);
  return {now.dot(coefficients), std::sqrt(std::max(0.0, now.dot(spread))), used};
}

double ZeroComparison::limit_nm() const {
  return 3 * std::hypot(predicted.sd_nm, kHomingAllowance_nm, kClosureNoise_nm);
}

bool ZeroComparison::surprising() const { return std::abs(difference_nm()) > limit_nm(); }

std::string ZeroComparison::sentence() const {
  return fmt::format(
      "the zero moved by {:+.0f} nm, {:+.0f} nm were expected from the temperatures (sd {:.0f} nm, "
      "from {} returns to zero): "
      "difference {:+.0f} nm, limit {:.0f} nm{}",
      found_nm, predicted.shift_nm, predicted.sd_nm, predicted.observations, difference_nm(),
      limit_nm(),
      surprising() ? ": look for a slipped reference, a lost fringe or something that was touched"
                   : "");
}

double drift_nm_per_min(std::span<const double> times_s, std::span<const double> zeros_nm) {
  const auto n = static_cast<double>(times_s.size());
  double time_sum = 0, zero_sum = 0;
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    time_sum += times_s[i];
    zero_sum += zeros_nm[i];
  }
  double products = 0, squares = 0;
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    const double t = times_s[i] - time_sum / n;
    products += t * (zeros_nm[i] - zero_sum / n);
    squares += t * t;
  }
  return squares > 0 ? 60 * products / squares : 0;
}

}  // namespace driftwise::application
