#include "server/diagnosis/growth/held_out_mean.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/core/text/quantity_text.h"
#include "server/diagnosis/growth/extension.h"
#include "server/diagnosis/rows/held_out_gain.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::size_t kFewestHeldOut = 4;

// What each learning row adds to the mean that is predicted of the held-out rows:
// X (X' X)^-1 c by the QR decomposition of X, columns scaled to unit length.
Eigen::VectorXd weights_in_mean(const Problem& problem, const Eigen::MatrixXd& columns) {
  Eigen::MatrixXd x = rows_of(columns, problem.learn);
  const Eigen::VectorXd scale = x.colwise().norm().cwiseMax(1e-300);
  x = x * scale.cwiseInverse().asDiagonal();
  const Eigen::VectorXd c =
      rows_of(columns, problem.judge).colwise().mean().transpose().cwiseQuotient(scale);
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(x);
  qr.setThreshold(1e-9);
  const Eigen::Index rank = qr.rank();
  const Eigen::VectorXd permuted = qr.colsPermutation().transpose() * c;
  Eigen::VectorXd along = Eigen::VectorXd::Zero(x.rows());
  along.head(rank) = qr.matrixR()
                         .topLeftCorner(rank, rank)
                         .triangularView<Eigen::Upper>()
                         .transpose()
                         .solve(permuted.head(rank));
  return qr.householderQ() * along;
}

// Spread of every dataset row's noise over the others', of an output. Of a motor behind a
// coordinate frame: root mean square over the coordinates.
Eigen::VectorXd spread_of(const Problem& problem, const std::string& output) {
  if (problem.row_sd.size() == 0)
    return Eigen::VectorXd::Ones(static_cast<Eigen::Index>(problem.data().rows));
  for (std::size_t o = 0; o < problem.outputs.size(); ++o)
    if (problem.outputs[o].channel.symbol == output)
      return problem.row_sd.col(static_cast<Eigen::Index>(o));
  return problem.row_sd.cwiseAbs2().rowwise().mean().cwiseSqrt();
}

// Learning rows within two correlation times of the slow noise.
double rows_together(const Problem& problem, double tau_s) {
  const auto& time = problem.data().time_s;
  if (time.empty() || tau_s <= 0 || problem.learn.size() < 2) return 1;
  const double span = time[problem.learn.back()] - time[problem.learn.front()];
  const double step = span / static_cast<double>(problem.learn.size() - 1);
  if (!(step > 0)) return 1;
  return std::clamp(2 * tau_s / step, 1.0, static_cast<double>(problem.learn.size()));
}

// As the noise is: without what the search's values were freed of, which no noise describes.
double mean_held_out(const Problem& problem, const Extension& extension,
                     const OutputSummary& output) {
  for (std::size_t o = 0; o < problem.outputs.size(); ++o)
    if (const auto& own = problem.outputs[o];
        own.channel.symbol == output.output && own.freed_of.size() > 0)
      return rows_of(residuals(problem, own, extension.described(o)), problem.judge).mean();
  return *output.mean_validation_after;
}

}  // namespace

std::vector<LeftOver> means_beyond_noise(const Problem& problem,
                                         const std::vector<OutputSummary>& outputs,
                                         const Extension& extension, double alpha) {
  std::vector<LeftOver> beyond;
  // The mean over blocks that are held out in turn is that of the fit: none.
  if (problem.judged_in_turn || problem.judge.size() < kFewestHeldOut) return beyond;
  const Eigen::VectorXd weights = weights_in_mean(problem, extension.all().columns);
  // The noise is that of the search's rows, which are averages of so many.
  const auto averaged = static_cast<double>(problem.rows_per_block);
  const auto judged = static_cast<double>(problem.judge.size());
  for (const auto& output : outputs) {
    if (!output.mean_validation_after) continue;
    const double white = output.noise_white_sd * output.noise_white_sd * averaged,
                 slow = output.noise_slow_sd * output.noise_slow_sd;
    const Eigen::VectorXd of_all = spread_of(problem, output.output),
                          spread = rows_of(of_all, problem.judge);
    const double leverage = weights.cwiseProduct(rows_of(of_all, problem.learn)).squaredNorm();
    const double variance = white * spread.squaredNorm() / (judged * judged) +
                            slow * std::pow(spread.mean(), 2) +
                            (white + slow * rows_together(problem, output.noise_tau_s)) * leverage;
    if (!(variance > 0)) continue;
    const double mean = mean_held_out(problem, extension, output);
    const double z = std::abs(mean) / std::sqrt(variance);
    const double p =
        std::min(1.0, std::erfc(z / std::numbers::sqrt2) * static_cast<double>(outputs.size()));
    if (p < alpha)
      beyond.push_back({"the held-out rows as a whole: " + output.output + " errs by " +
                            digits_text(mean, 3, true) + " " + output.unit + " on average",
                        p});
  }
  return beyond;
}

}  // namespace driftwise::diagnosis
