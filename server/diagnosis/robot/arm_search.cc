#include "server/diagnosis/robot/arm_search.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "server/calibration/linear/tail.h"
#include "server/diagnosis/noise/ground.h"
#include "server/diagnosis/robot/left_out.h"
#include "server/diagnosis/rows/held_out_gain.h"

namespace driftwise::diagnosis {
namespace {

using Eigen::Index;

constexpr Index kShortBlocks = 60;
constexpr double kRivalWithin = 6, kSpreadLevel = 0.95;

double normal_below(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }

}  // namespace

ArmSearch::ArmSearch(const WhitenedGeometry& whole, const std::vector<Index>& geometry,
                     const std::vector<ArmCause>& causes, Eigen::MatrixXd angles,
                     const std::vector<std::size_t>& learn)
    : whole_(whole),
      geometry_(geometry),
      causes_(causes),
      angles_(std::move(angles)),
      learn_(learn) {
  Index turns = 0;
  for (const auto& cause : causes_) {
    first_.push_back(turns);
    turns += cause.turns_rad.cols();
  }
  rows_ = static_cast<Index>(learn_.size());
  outputs_ = whole_.y.size() / rows_;
  Eigen::MatrixXd base = whole_.columns(Eigen::all, geometry_);
  const Eigen::RowVectorXd lengths = base.colwise().norm().cwiseMax(1e-300);
  base = base * lengths.cwiseInverse().asDiagonal();
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(base);
  basis_ = qr.householderQ() * Eigen::MatrixXd::Identity(base.rows(), base.cols());
  turns_ = whole_.columns.rightCols(turns);
  turns_ -= basis_ * (basis_.transpose() * turns_).eval();
  y_ = whole_.y - basis_ * (basis_.transpose() * whole_.y);
  y_ -= basis_ * (basis_.transpose() * y_).eval();
  weigh_again();
}

void ArmSearch::weigh_again() {
  Eigen::VectorXd left = y_;
  const auto columns = columns_of(in_);
  if (!in_.empty())
    left -= turns_(Eigen::all, columns) * scales_of(in_).cwiseProduct(fit(in_, 1).mean);
  double noise =
      std::sqrt(left.squaredNorm() /
                static_cast<double>(std::ssize(left) - basis_.cols() - std::ssize(columns)));
  if (!(noise > 0 && std::isfinite(noise))) noise = 1;  // as many columns as numbers
  noise_ *= noise;
  y_ /= noise;
  turns_ /= noise;
  gram_ = turns_.transpose() * turns_;
  along_ = turns_.transpose() * y_;
  typical_.clear();
  for (std::size_t c = 0; c < causes_.size(); ++c) {
    const auto whole_turns = whole_.columns.rightCols(turns_.cols()).middleCols(first(c), width(c));
    const double largest = whole_turns.cwiseAbs().maxCoeff() / noise_;
    typical_.push_back(
        std::max(causes_[c].typical, causes_[c].of_noise / std::max(largest, 1e-300)));
  }
  correlated_.clear();
  for (std::size_t c = 0; c < causes_.size(); ++c) correlated_.push_back(correlation_of(c));
}

// Of what all causes together leave.
double ArmSearch::correlation_of(std::size_t cause) const {
  std::vector<Soft> all;
  for (std::size_t c = 0; c < causes_.size(); ++c) all.push_back({c, 1});
  const Fit fitted = fit(all, 1);
  const Eigen::VectorXd amplitudes = scales_of(all).cwiseProduct(fitted.mean);
  const Eigen::VectorXd left = y_ - turns_ * amplitudes;
  double scores = 0, independent = 0;
  for (Index k = first(cause); k < first(cause) + width(cause); ++k) {
    for (Index block = 0; block < kShortBlocks; ++block) {
      const Index begin = block * rows_ / kShortBlocks, end = (block + 1) * rows_ / kShortBlocks;
      double score = 0;
      for (Index o = 0; o < outputs_; ++o)
        score += turns_.col(k)
                     .segment(o * rows_ + begin, end - begin)
                     .dot(left.segment(o * rows_ + begin, end - begin));
      scores += score * score;
    }
    independent +=
        turns_.col(k).squaredNorm() * left.squaredNorm() / static_cast<double>(y_.size());
  }
  return independent > 0 ? std::max(1.0, scores / independent) : 1;
}

std::vector<Index> ArmSearch::columns_of(const std::vector<Soft>& soft) const {
  std::vector<Index> columns;
  for (const auto& one : soft)
    for (Index k = 0; k < width(one.cause); ++k) columns.push_back(first(one.cause) + k);
  return columns;
}

Eigen::VectorXd ArmSearch::scales_of(const std::vector<Soft>& soft) const {
  std::vector<double> scales;
  for (const auto& one : soft)
    for (Index k = 0; k < width(one.cause); ++k) scales.push_back(one.share * typical_[one.cause]);
  return Eigen::Map<Eigen::VectorXd>(scales.data(), static_cast<Index>(scales.size()));
}

ArmSearch::Fit ArmSearch::fit(const std::vector<Soft>& soft, double rows_per_row) const {
  if (soft.empty()) return {};
  const auto columns = columns_of(soft);
  const Eigen::VectorXd scales = scales_of(soft);
  Eigen::MatrixXd g =
      scales.asDiagonal() * gram_(columns, columns) * scales.asDiagonal() / rows_per_row;
  g.diagonal().array() += 1;
  const Eigen::VectorXd b = scales.cwiseProduct(along_(columns).matrix()) / rows_per_row;
  const Eigen::LLT<Eigen::MatrixXd> cholesky(g);
  Fit result;
  result.mean = cholesky.solve(b);
  result.error =
      cholesky.solve(Eigen::MatrixXd::Identity(g.rows(), g.cols())).diagonal().cwiseSqrt();
  result.two_ln = result.explained = b.dot(result.mean);
  for (Index k = 0; k < g.cols(); ++k) result.two_ln -= 2 * std::log(cholesky.matrixL()(k, k));
  Index at = 0;
  for (const auto& one : soft) {
    if (causes_[one.cause].one_signed)
      result.two_ln +=
          2 * std::log(std::max(2 * normal_below(result.mean[at] / result.error[at]), 1e-300));
    at += width(one.cause);
  }
  return result;
}

std::optional<std::size_t> ArmSearch::index_of(std::size_t cause) const {
  for (std::size_t i = 0; i < in_.size(); ++i)
    if (in_[i].cause == cause) return i;
  return std::nullopt;
}

std::vector<ArmSearch::Soft> ArmSearch::beside(std::size_t cause) const {
  std::vector<Soft> all;
  for (const auto& one : in_)
    if (one.cause != cause) all.push_back(one);
  for (std::size_t c = 0; c < causes_.size(); ++c)
    if (c != cause && causes_[c].certain && !index_of(c)) all.push_back({c, 1});
  return all;
}

ArmSearch::Evidence ArmSearch::evidence(std::size_t cause, const std::vector<Soft>& base) const {
  const double rows_per_row = correlated_[cause];
  const Fit without = fit(base, rows_per_row);
  ByShare two_ln{};
  std::array<Fit, kPriorShares.size()> fits;
  const auto& what = causes_[cause];
  for (std::size_t w = 0; w < two_ln.size(); ++w) {
    auto with = base;
    with.push_back({cause, kPriorShares[w]});
    fits[w] = fit(with, rows_per_row);
    two_ln[w] = fits[w].two_ln - without.two_ln;
  }
  Evidence result{.two_ln = averaged(two_ln, false), .share = likeliest_share(two_ln, false)};
  const auto best = static_cast<std::size_t>(std::ranges::find(kPriorShares, result.share) -
                                             kPriorShares.begin());
  const Fit& chosen = fits[best];
  const Index k = width(cause);
  const Eigen::VectorXd mean = chosen.mean.tail(k) * result.share,
                        error = chosen.error.tail(k) * result.share;
  result.nameable =
      (mean.cwiseAbs() - 2 * error).maxCoeff() <= what.range && (!what.one_signed || mean[0] > 0);
  auto free = base;
  free.push_back({cause, 3 * kPriorShares.front()});
  const Fit wide = fit(free, rows_per_row);
  result.likelihood = wide.explained - without.explained;
  return result;
}

ArmGate ArmSearch::gate(std::size_t cause, const std::vector<Soft>& base, double share) const {
  auto with = base;
  with.push_back({cause, share});
  const auto columns = columns_of(with);
  const LeftOut left_out(basis_, turns_(Eigen::all, columns) * scales_of(with).asDiagonal(),
                         Eigen::VectorXd::Ones(static_cast<Index>(columns.size())), width(cause),
                         y_, rows_);
  const auto parts = folds_of_driver(causes_[cause].driver(learn_));
  ArmGate result{
      .by_time = left_out.growth_over_time(folds_of_time(static_cast<std::size_t>(rows_))),
      .by_places = left_out.growth(folds_of_places(angles_)),
      .by_driver = left_out.growth(parts),
      .t_by_driver = left_out.t_without(parts)};
  const double least = calibration::t_quantile(kSpreadLevel, static_cast<double>(parts.size()) - 1);
  result.passes = result.by_time > 0 && result.by_places > 0 && result.by_driver > 0 &&
                  (causes_[cause].certain || result.t_by_driver > least);
  return result;
}

// Half of alpha is for what acts on every arm, half for the rest; alike within each half.
double ArmSearch::chance_of(std::size_t cause, double two_ln) const {
  const auto alike = std::ranges::count(causes_, causes_[cause].certain, &ArmCause::certain);
  const bool all = alike == std::ssize(causes_);
  const double price = static_cast<double>(alike) * (all ? 1 : 2);
  return std::min(1.0, price * std::exp(-two_ln / 2));
}

// Twice its evidence is about what it explains less the logarithm of that: solved once over.
double ArmSearch::least_shown(std::size_t cause) const {
  const double needed = -2 * std::log(alpha_ / chance_of(cause, 0));
  const double explained = turns_.middleCols(first(cause), width(cause)).squaredNorm() /
                           static_cast<double>(width(cause)) / correlated_[cause];
  return std::sqrt((needed + std::log(1 + needed)) / std::max(explained, 1e-300));
}

// Two wheels of one gear: what the second leaves spoils the prediction by the first, and the other
// way round. The strongest cause beside `one` that is named with it in, and predicts as it does
// then.
std::optional<ArmSearch::Soft> ArmSearch::companion(const Soft& one,
                                                    const std::vector<char>& ruled_out) const {
  std::optional<std::size_t> best;
  Evidence most;
  const auto with = [&](const Soft& soft, std::size_t cause) {
    auto base = beside(cause);
    std::erase_if(base, [&](const Soft& other) { return other.cause == soft.cause; });
    base.push_back(soft);
    return base;
  };
  for (std::size_t c = 0; c < causes_.size(); ++c) {
    if (ruled_out[c] != 0 || index_of(c) || c == one.cause) continue;
    const auto found = evidence(c, with(one, c));
    if (!found.nameable || chance_of(c, found.two_ln) > alpha_) continue;
    if (!best || found.two_ln > most.two_ln) best = c, most = found;
  }
  if (!best) return std::nullopt;
  const Soft second{*best, most.share};
  const auto again = evidence(one.cause, with(second, one.cause));
  if (!again.nameable || chance_of(one.cause, again.two_ln) > alpha_ ||
      !gate(*best, with(one, *best), most.share).passes ||
      !gate(one.cause, with(second, one.cause), one.share).passes)
    return std::nullopt;
  return second;
}

void ArmSearch::enter(std::vector<char>& ruled_out) {
  while (true) {
    std::optional<std::size_t> best;
    Evidence most;
    for (std::size_t c = 0; c < causes_.size(); ++c) {
      if (ruled_out[c] != 0 || index_of(c)) continue;
      const auto one = evidence(c, beside(c));
      if (!one.nameable || chance_of(c, one.two_ln) > alpha_) continue;
      if (!best || one.two_ln > most.two_ln) best = c, most = one;
    }
    if (!best) break;
    const auto judged = gate(*best, beside(*best), most.share);
    if (!judged.passes) {
      if (const auto second = companion({*best, most.share}, ruled_out)) {
        in_.push_back({*best, most.share});
        in_.push_back(*second);
        weigh_again();
        continue;
      }
      ruled_out[*best] = 1;
      refused_.push_back({*best, most.two_ln, judged});
      continue;
    }
    in_.push_back({*best, most.share});
    // What a later one explains goes.
    for (std::size_t i = 0; i < in_.size(); ++i) {
      const auto again = evidence(in_[i].cause, beside(in_[i].cause));
      if (again.nameable && chance_of(in_[i].cause, again.two_ln) <= alpha_) {
        in_[i].share = again.share;
        continue;
      }
      ruled_out[in_[i].cause] = 1;
      in_.erase(in_.begin() + static_cast<std::ptrdiff_t>(i));
      break;
    }
    weigh_again();
  }
}

// The one whose going mends most, where rows that took no part are described worse with it, over
// all outputs together: a joint moves them all.
std::optional<std::size_t> ArmSearch::harmful() const {
  const auto left = [this](std::size_t without) {
    return Eigen::VectorXd(whole_.y_raw_judge - whole_.raw_judge * coefficients(without));
  };
  const auto rows = static_cast<std::size_t>(whole_.y_raw_judge.size() / outputs_);
  const Eigen::VectorXd with = left(kNone);
  std::optional<std::size_t> worst;
  double most = 0;
  for (const auto& one : in_) {
    const auto compared = held_out_ratio_together(left(one.cause), with, rows);
    if (compared.is_worse() && compared.ratio() > most) most = compared.ratio(), worst = one.cause;
  }
  return worst;
}

void ArmSearch::search(double alpha) {
  alpha_ = alpha;
  std::vector<char> ruled_out(causes_.size(), 0);
  enter(ruled_out);
  while (const auto worst = harmful()) {
    ruled_out[*worst] = 1;
    harmful_.push_back(*worst);
    std::erase_if(in_, [&](const Soft& one) { return one.cause == *worst; });
    weigh_again();
    enter(ruled_out);
  }
  describe();
}

void ArmSearch::describe() {
  double most = 1;
  for (const auto& one : in_) most = std::max(most, correlated_[one.cause]);
  const Fit all = fit(in_, most);
  Index at = 0;
  for (const auto& one : in_) {
    const Index k = width(one.cause);
    const double scale = one.share * typical_[one.cause];
    const auto base = beside(one.cause);
    const auto own = evidence(one.cause, base);
    const Fit scatter = fit(in_, correlated_[one.cause]);  // as its evidence counts the rows
    NamedArmCause named{.cause = one.cause,
                        .amplitude = scale * all.mean.segment(at, k),
                        .error = scale * scatter.error.segment(at, k),
                        .two_ln_bf = own.two_ln,
                        .p_adjusted = chance_of(one.cause, own.two_ln),
                        .gain_2lnl = own.likelihood,
                        .gate = gate(one.cause, base, one.share)};
    for (std::size_t c = 0; c < causes_.size(); ++c) {
      if (c == one.cause || index_of(c)) continue;
      auto others = base;
      std::erase_if(others, [c](const Soft& soft) { return soft.cause == c; });
      const auto rival = evidence(c, others);
      if (rival.nameable && rival.likelihood > own.likelihood - kRivalWithin)
        named.rivals.push_back(c);
    }
    named_.push_back(std::move(named));
    at += k;
  }
  std::ranges::stable_sort(named_, std::ranges::greater{}, &NamedArmCause::two_ln_bf);
}

Eigen::VectorXd ArmSearch::coefficients(std::size_t without) const {
  auto soft = in_;
  std::erase_if(soft, [without](const Soft& one) { return one.cause == without; });
  double most = 1;
  for (const auto& one : soft) most = std::max(most, correlated_[one.cause]);
  const Fit fitted = fit(soft, most);
  const auto columns = columns_of(soft);
  const Eigen::VectorXd scales = scales_of(soft);
  Eigen::VectorXd all = Eigen::VectorXd::Zero(whole_.columns.cols());
  const Index turns = turns_.cols(), others = whole_.columns.cols() - turns;
  Eigen::VectorXd left = whole_.y;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto at = static_cast<Index>(i);
    all[others + columns[i]] = scales[at] * fitted.mean[at];
    left -= all[others + columns[i]] * whole_.columns.col(others + columns[i]);
  }
  Eigen::MatrixXd base = whole_.columns(Eigen::all, geometry_);
  const Eigen::VectorXd lengths = base.colwise().norm().cwiseMax(1e-300);
  base = base * lengths.cwiseInverse().asDiagonal();
  const Eigen::VectorXd b = base.householderQr().solve(left);
  for (std::size_t k = 0; k < geometry_.size(); ++k)
    all[geometry_[k]] = b[static_cast<Index>(k)] / lengths[static_cast<Index>(k)];
  return all;
}

}  // namespace driftwise::diagnosis
