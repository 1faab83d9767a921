#include "server/diagnosis/noise/tails.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "server/diagnosis/noise/ground.h"
#include "server/diagnosis/noise/robust.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kMostGross = 0.05;  // of the rows
constexpr double kSettled = 1e-3;    // growth of the log-likelihood in one round
constexpr int kDrawnTails = 99;

}  // namespace

Tails::Tails(const Eigen::VectorXd& left) : square_(left.array().square()) {
  const double robust = robust_sd({left.data(), left.data() + left.size()});
  start_ = std::max(robust * robust, 1e-300);
  for (std::size_t f = 0; f < kFreedoms.size(); ++f) {
    one_law_[f] = fit(kFreedoms[f], false);
    two_laws_[f] = fit(kFreedoms[f], true);
  }
}

Tails::Fit Tails::fit(double freedom, bool with_gross) const {
  constexpr int kRounds = 40;
  constexpr double kFar = 16;  // squared: where a first guess takes rows for gross
  Fit result{-1e300, start_, Eigen::ArrayXd::Zero(square_.size())};
  if (with_gross) result.gross = (square_ > kFar * start_).cast<double>();
  double scale = start_;
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::ArrayXd kept = 1 - result.gross;
    const Eigen::ArrayXd weight = (freedom + 1) / (freedom + square_ / scale);
    scale = std::max((kept * weight * square_).sum() / kept.sum(), 1e-300);
    result.square = scale;
    const double norm = std::lgamma((freedom + 1) / 2) - std::lgamma(freedom / 2) -
                        0.5 * std::log(freedom * std::numbers::pi * scale);
    const Eigen::ArrayXd ordinary =
        (norm - (freedom + 1) / 2 * (1 + square_ / (freedom * scale)).log()).exp();
    const double count = result.gross.sum(), before = result.log_likelihood;
    if (count < 0.5) {
      result.gross.setZero();
      result.log_likelihood = ordinary.max(1e-300).log().sum();
      if (std::abs(result.log_likelihood - before) < kSettled) break;
      continue;
    }
    const double share = std::min(count / static_cast<double>(square_.size()), kMostGross);
    const double size = (result.gross * square_).sum() / count;
    const Eigen::ArrayXd wrong =
        share * (-square_ / (2 * size)).exp() / std::sqrt(2 * std::numbers::pi * size);
    const Eigen::ArrayXd both = ((1 - share) * ordinary + wrong).max(1e-300);
    result.log_likelihood = both.log().sum();
    result.gross = wrong / both;
    if (std::abs(result.log_likelihood - before) < kSettled) break;
  }
  return result;
}

CommonTails common_tails(const std::vector<Tails>& outputs) {
  CommonTails result;
  double normal = 0, highest = -INFINITY;
  for (const Tails& one : outputs) normal += one.one_law(Tails::kFreedoms.size() - 1);
  for (std::size_t f = 0; f < Tails::kFreedoms.size(); ++f) {
    double sum = 0;
    for (const Tails& one : outputs) sum += one.one_law(f);
    if (sum > highest) highest = sum, result.freedom = f;
  }
  result.gain = 2 * (highest - normal);
  return result;
}

GrossGain gross_gain(const std::vector<Tails>& outputs, std::size_t output) {
  double without = -INFINITY, with = -INFINITY, others = -INFINITY, own = -INFINITY;
  GrossGain result;
  for (std::size_t f = 0; f < Tails::kFreedoms.size(); ++f) {
    double rest = 0;
    for (std::size_t o = 0; o < outputs.size(); ++o)
      if (o != output) rest += outputs[o].one_law(f);
    others = std::max(others, rest);
    own = std::max(own, outputs[output].one_law(f));
    without = std::max(without, rest + outputs[output].one_law(f));
    if (rest + outputs[output].two_laws(f) <= with) continue;
    with = rest + outputs[output].two_laws(f);
    result.freedom = f;
  }
  result.gain = 2 * (with - std::max(without, others + own - kOwnShape / 2));
  return result;
}

double chance_of_gross(const std::vector<Tails>& outputs, Eigen::Index rows, double gain) {
  std::mt19937_64 random(1);
  std::student_t_distribution<double> student(Tails::kFreedoms[common_tails(outputs).freedom]);
  std::vector<double> largest;
  for (int k = 0; k < kDrawnTails; ++k) {
    std::vector<Tails> drawn;
    for (std::size_t o = 0; o < outputs.size(); ++o)
      drawn.emplace_back(Eigen::VectorXd::NullaryExpr(rows, [&] { return student(random); }));
    largest.push_back(0);
    for (std::size_t o = 0; o < drawn.size(); ++o)
      largest.back() = std::max(largest.back(), gross_gain(drawn, o).gain);
  }
  const auto above = largest.begin() + static_cast<std::ptrdiff_t>(
                                           (1 - kTailFrom) * static_cast<double>(largest.size()));
  std::ranges::nth_element(largest, above);
  return kTailFrom * std::exp(std::min(0.0, *above - gain) / 2);
}

}  // namespace driftwise::diagnosis
