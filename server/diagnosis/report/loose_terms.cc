#include "server/diagnosis/report/loose_terms.h"

#include <Eigen/QR>
#include <cmath>
#include <cstdio>

#include "server/diagnosis/rows/held_out_gain.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kWorthSaying = 1;  // of the noise: more and the prediction is mostly coefficients
constexpr double kEnough = 0.5;     // terms are named until so much is left
constexpr double kAsLoose = 0.5;    // of what the loosest adds to the square
constexpr std::size_t kMostTerms = 6;

double rms_error(const Eigen::MatrixXd& rows, const Eigen::MatrixXd& covariance) {
  return std::sqrt((rows * covariance).cwiseProduct(rows).sum() / static_cast<double>(rows.rows()));
}

}  // namespace

std::optional<LooseTerms> loose_terms(const Problem& problem) {
  if (problem.folds.size() != 1 || problem.judge.size() < kFewestJudges) return std::nullopt;
  const auto& fold = problem.folds.front();
  Eigen::MatrixXd learn = rows_of(problem.base_columns, fold.learn),
                  judge = rows_of(problem.base_columns, fold.judge);
  if (!learn.allFinite() || !judge.allFinite() || learn.rows() <= learn.cols()) return std::nullopt;
  const Eigen::VectorXd scale = learn.colwise().norm().cwiseMax(1e-300);
  learn *= scale.cwiseInverse().asDiagonal();
  judge *= scale.cwiseInverse().asDiagonal();
  const Eigen::Index k = learn.cols();
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(learn);
  if (qr.rank() < k) return std::nullopt;
  const Eigen::MatrixXd r_inverse =
      qr.matrixR().topRows(k).template triangularView<Eigen::Upper>().solve(
          Eigen::MatrixXd::Identity(k, k));
  const Eigen::MatrixXd root = qr.colsPermutation() * r_inverse;
  Eigen::MatrixXd covariance = root * root.transpose();
  LooseTerms result{rms_error(judge, covariance), 0, {}};
  if (result.with < kWorthSaying) return std::nullopt;
  result.without = result.with;
  std::vector<char> may_go;  // not the constants
  for (const auto& term : problem.base) may_go.push_back(effects::symbols_of(term).empty() ? 0 : 1);
  while (result.without > kEnough && result.terms.size() < kMostTerms) {
    // Leaving term t out takes C_t C_t' / C_tt from the covariance.
    const Eigen::MatrixXd along = judge * covariance;
    Eigen::VectorXd taken = Eigen::VectorXd::Zero(k);
    for (Eigen::Index t = 0; t < k; ++t)
      if (may_go[static_cast<std::size_t>(t)] != 0)
        taken[t] = along.col(t).squaredNorm() / covariance(t, t);
    const double most = taken.maxCoeff();
    if (!(most > 0)) break;
    // Of terms that are loose together the last one, for formulas have the powers in their order.
    Eigen::Index loosest = k - 1;
    while (taken[loosest] < kAsLoose * most) --loosest;
    const Eigen::VectorXd gone = covariance.col(loosest);
    covariance -= gone * gone.transpose() / gone[loosest];
    covariance.row(loosest).setZero();
    covariance.col(loosest).setZero();
    may_go[static_cast<std::size_t>(loosest)] = 0;
    result.terms.push_back(effects::notation(problem.base[static_cast<std::size_t>(loosest)]));
    result.without = rms_error(judge, covariance);
  }
  return result;
}

std::string sentence(const LooseTerms& loose) {
  std::string terms;
  for (const auto& term : loose.terms) terms += (terms.empty() ? "" : ", ") + term;
  char sizes[64];
  std::snprintf(sizes, sizeof sizes, "%.2g times the noise (%.2g without them)", loose.with,
                loose.without);
  return "the calibration rows hardly determine these terms of the baseline: " + terms +
         ". On the held-out rows its coefficients are uncertain by " + sizes +
         ", and a finding's gain there says little. Measure at more places, or leave the terms out";
}

}  // namespace driftwise::diagnosis
