#include "server/diagnosis/rows/held_out_gain.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "server/core/units.h"
#include "server/diagnosis/answer/u90.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::size_t kJudgeBlocks = 20, kFewestBlocks = 4;

Eigen::VectorXd fitted_elsewhere(const SoftBase& base, const Eigen::VectorXd& measured,
                                 const std::vector<std::size_t>& learn) {
  const Eigen::MatrixXd& columns = base.columns;
  const Eigen::Index soft = columns.cols() - base.free_count();
  const auto rows = static_cast<Eigen::Index>(learn.size());
  Eigen::MatrixXd x = Eigen::MatrixXd::Zero(rows + soft, columns.cols());
  x.topRows(rows) = rows_of(columns, learn);
  for (Eigen::Index k = 0; k < soft; ++k)  // a prior is one row more: 0 +- s
    x(rows + k, columns.cols() - soft + k) = std::sqrt(base.precision[columns.cols() - soft + k]);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(rows + soft);
  y.head(rows) = rows_of(measured, learn);
  const Eigen::VectorXd scale = x.colwise().norm().cwiseMax(1e-300);
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(x * scale.cwiseInverse().asDiagonal());
  qr.setThreshold(1e-9);
  const Eigen::VectorXd b = qr.solve(y).cwiseQuotient(scale);
  return measured - columns * b;
}

Eigen::VectorXd as_read(const ProblemOutput& output) {
  if (output.freed_of.size() == 0) return output.measured;
  return output.measured + output.freed_of;
}

double ln_ratio(const Eigen::VectorXd& before, const Eigen::VectorXd& after) {
  return 0.5 * std::log(after.squaredNorm() / std::max(before.squaredNorm(), 1e-300));
}

}  // namespace

Eigen::VectorXd residuals(const Problem& problem, const ProblemOutput& output,
                          const SoftBase& base) {
  return fitted_elsewhere(base, output.measured, problem.learn);
}

Eigen::VectorXd residuals_as_read(const Problem& problem, const ProblemOutput& output,
                                  const SoftBase& base) {
  return fitted_elsewhere(base, as_read(output), problem.learn);
}

Eigen::VectorXd judged_residuals(const Problem& problem, const ProblemOutput& output,
                                 const SoftBase& base) {
  Eigen::VectorXd judged(static_cast<Eigen::Index>(problem.judge.size()));
  Eigen::Index at = 0;
  for (const auto& fold : problem.folds) {
    const auto count = static_cast<Eigen::Index>(fold.judge.size());
    judged.segment(at, count) =
        rows_of(fitted_elsewhere(base, as_read(output), fold.learn), fold.judge);
    at += count;
  }
  return judged;
}

HeldOut held_out(const Problem& problem, const ProblemOutput& output, const SoftBase& before,
                 const SoftBase& after) {
  return held_out(judged_residuals(problem, output, before),
                  judged_residuals(problem, output, after));
}

HeldOut held_out(const Eigen::VectorXd& judged_before, const Eigen::VectorXd& judged) {
  HeldOut result{figures_of(judged_before), figures_of(judged), {}, {}};
  // Jackknife over contiguous blocks: autocorrelation stays inside them.
  const auto n = static_cast<std::size_t>(judged.size());
  const std::size_t blocks = std::min(kJudgeBlocks, std::max(n / 4, std::min(n, kFewestBlocks)));
  std::vector<ErrorFigures> without;
  for (std::size_t k = 0; k < blocks && blocks >= kFewestBlocks; ++k) {
    std::vector<std::size_t> kept;
    for (std::size_t i = 0; i < n; ++i)
      if (i * blocks / n != k) kept.push_back(i);
    without.push_back(figures_of(rows_of(judged, kept)));
  }
  const auto interval = [&without](double whole, double ErrorFigures::*figure) -> Interval {
    if (without.empty()) return {whole, whole};
    const auto count = static_cast<double>(without.size());
    double mean = 0, squares = 0;
    for (const auto& one : without) mean += std::log(one.*figure) / count;
    for (const auto& one : without) squares += std::pow(std::log(one.*figure) - mean, 2);
    const double error = std::sqrt(squares * (count - 1) / count);
    return {whole * std::exp(-kSigmaToU90 * error), whole * std::exp(kSigmaToU90 * error)};
  };
  result.u90_after_ci90 = interval(result.after.u90, &ErrorFigures::u90);
  result.a90_after_ci90 = interval(result.after.a90, &ErrorFigures::a90);
  return result;
}

HeldOutRatio held_out_ratio(const Problem& problem, const ProblemOutput& output,
                            const SoftBase& before, const SoftBase& after) {
  return held_out_ratio(judged_residuals(problem, output, before),
                        judged_residuals(problem, output, after));
}

// Jackknife over contiguous blocks of the ratio itself: what both share cancels.
HeldOutRatio held_out_ratio(const Eigen::VectorXd& without, const Eigen::VectorXd& with) {
  const auto n = static_cast<std::size_t>(without.size());
  if (n == 0) return {};
  HeldOutRatio result{std::sqrt(without.squaredNorm() / static_cast<double>(n)),
                      std::sqrt(with.squaredNorm() / static_cast<double>(n)),
                      {}};
  const std::size_t blocks = std::min(kJudgeBlocks, n / 4);
  const auto count = static_cast<double>(blocks);
  std::vector<double> left_out;
  for (std::size_t k = 0; k < blocks; ++k) {
    std::vector<std::size_t> kept;
    for (std::size_t i = 0; i < n; ++i)
      if (i * blocks / n != k) kept.push_back(i);
    left_out.push_back(ln_ratio(rows_of(without, kept), rows_of(with, kept)));
  }
  double mean = 0, squares = 0;
  for (const double one : left_out) mean += one / count;
  for (const double one : left_out) squares += (one - mean) * (one - mean);
  const double error =
      blocks < 2 ? INFINITY : kSigmaToU90 * std::sqrt(squares * (count - 1) / count);
  const double middle = ln_ratio(without, with);
  result.ratio_ci90 = {std::exp(middle - error), std::exp(middle + error)};
  return result;
}

HeldOutRatio held_out_ratio_together(const Eigen::VectorXd& before, const Eigen::VectorXd& after,
                                     std::size_t rows) {
  if (static_cast<std::size_t>(before.size()) < kFewestJudges) return {};
  const auto n = static_cast<Eigen::Index>(rows), outputs = before.size() / n;
  const Eigen::RowVectorXd scale = before.reshaped(n, outputs).colwise().norm().cwiseMax(1e-300);
  const auto by_row = [&](const Eigen::VectorXd& stacked) {
    const Eigen::MatrixXd scaled = stacked.reshaped(n, outputs) * scale.cwiseInverse().asDiagonal();
    return Eigen::VectorXd(scaled.transpose().reshaped());
  };
  return held_out_ratio(by_row(before), by_row(after));
}

double harm(const Eigen::VectorXd& before, const Eigen::VectorXd& after, std::size_t rows) {
  double worst = 0;
  const auto look = [&worst](const HeldOutRatio& one) {
    if (one.is_worse()) worst = std::max(worst, one.ratio());
  };
  const auto n = static_cast<Eigen::Index>(rows);
  for (Eigen::Index at = 0; at < before.size() && rows >= kFewestJudges; at += n)
    look(held_out_ratio(before.segment(at, n), after.segment(at, n)));
  look(held_out_ratio_together(before, after, rows));
  return worst;
}

}  // namespace driftwise::diagnosis
