#include "server/diagnosis/noise/ground.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace driftwise::diagnosis {
namespace {

constexpr double kAlreadyThere = 1e-4;  // of a column's whitened length
constexpr double kWidths = 3;           // prior widths within which causes are compared
constexpr double kLeast = 1e-12;        // of a sum of squares
constexpr double kErrors = 2;           // standard errors of a correlation that is none

// Columns whose amplitudes b have the prior N(0, width^2), integrated out: G = 1 + W' W with
// W = white x width. ln det of I + W W', and what the sum of squares loses.
struct Integrated {
  Integrated(const Eigen::MatrixXd& white, const Eigen::VectorXd& widths) : width(widths) {
    const Eigen::MatrixXd scaled = white * width.asDiagonal();
    Eigen::MatrixXd g = scaled.transpose() * scaled;
    g.diagonal().array() += 1;
    cholesky.compute(g);
    for (Eigen::Index k = 0; k < g.cols(); ++k)
      log_determinant += 2 * std::log(cholesky.matrixL()(k, k));
  }
  // along: white' left.
  double taken(const Eigen::VectorXd& along) const {
    return cholesky.matrixL().solve(width.cwiseProduct(along)).squaredNorm();
  }
  Eigen::VectorXd amplitudes(const Eigen::VectorXd& along) const {
    return width.cwiseProduct(cholesky.solve(width.cwiseProduct(along)));
  }
  // Per unit of the noise.
  Eigen::VectorXd errors() const {
    const Eigen::MatrixXd inverse =
        cholesky.solve(Eigen::MatrixXd::Identity(width.size(), width.size()));
    return width.cwiseProduct(inverse.diagonal().cwiseSqrt());
  }

  Eigen::VectorXd width;
  Eigen::LLT<Eigen::MatrixXd> cholesky;
  double log_determinant = 0;
};

}  // namespace

double averaged(const ByShare& two_ln, bool may_not_act) {
  double top = may_not_act ? 0 : two_ln[0];
  for (const double one : two_ln) top = std::max(top, one);
  double sum = may_not_act ? std::exp(-top / 2) : 0;
  for (const double one : two_ln) sum += std::exp((one - top) / 2);
  return top + 2 * std::log(sum / static_cast<double>(two_ln.size() + (may_not_act ? 1 : 0)));
}

double likeliest_share(const ByShare& two_ln, bool may_not_act) {
  const auto best = std::ranges::max_element(two_ln);
  if (may_not_act && averaged(two_ln, false) < 0) return 0;
  return kPriorShares[static_cast<std::size_t>(best - two_ln.begin())];
}

double counted_times(const Eigen::Ref<const Eigen::VectorXd>& of_output,
                     const Eigen::MatrixXd& alike) {
  const Eigen::VectorXd gains = of_output.cwiseMax(0);
  const double sum = gains.sum();
  if (!(sum > 0)) return 1;
  const Eigen::VectorXd sizes = gains.cwiseSqrt();
  return std::max(1.0, sizes.dot(alike * sizes) / sum);
}

Eigen::MatrixXd outputs_alike(const Eigen::MatrixXd& correlation, double n) {
  const double chance = std::min(kErrors / std::sqrt(std::max(n, 1.0)), 0.5);
  Eigen::MatrixXd result =
      ((correlation.cwiseAbs().array() - chance) / (1 - chance)).max(0.0).matrix();
  result.diagonal().setOnes();
  return result;
}

double price_of(const NoiseShape& shape, Eigen::Index outputs) {
  return shape.slow_ratio > 0 ? kCorrelatedNoise / static_cast<double>(outputs) : 0;
}

SharedShape shared_shape(const Eigen::MatrixXd& criterion) {
  SharedShape best{INFINITY, {}};
  for (Eigen::Index common = 0; common < criterion.rows(); ++common) {
    SharedShape one;
    for (Eigen::Index o = 0; o < criterion.cols(); ++o) {
      Eigen::Index own = 0;
      const double lowest = criterion.col(o).minCoeff(&own) + kOwnShape;
      const bool shares = criterion(common, o) <= lowest;
      one.total += shares ? criterion(common, o) : lowest;
      one.shape.push_back(static_cast<std::size_t>(shares ? common : own));
    }
    if (one.total < best.total) best = std::move(one);
  }
  return best;
}

Eigen::MatrixXd news_of(const WhitenedSpace& space, Eigen::MatrixXd columns) {
  space.whiten(columns);
  const Eigen::RowVectorXd whole = columns.colwise().norm();
  space.project(columns);
  for (Eigen::Index j = 0; j < columns.cols(); ++j)
    if (columns.col(j).norm() < kLeastNew * whole[j]) columns.col(j).setZero();
  return columns;
}

Eigen::MatrixXd beyond(const WhitenedSpace& space, const Eigen::MatrixXd& columns) {
  // Lengths about the mean: a temperature of 20 degC is no longer than its changes are.
  Eigen::MatrixXd left = columns.rowwise() - columns.colwise().mean();
  space.whiten(left);
  const Eigen::RowVectorXd lengths = left.colwise().norm();
  space.project(left);
  Eigen::Index count = 0;
  for (Eigen::Index j = 0; j < left.cols(); ++j) {
    Eigen::VectorXd rest = left.col(j);
    for (int pass = 0; pass < 2; ++pass)  // twice is enough
      rest -= left.leftCols(count) * (left.leftCols(count).transpose() * rest).eval();
    const double length = rest.norm();
    if (!(length > kAlreadyThere * lengths[j]) || !std::isfinite(length)) continue;
    left.col(count++) = rest / length;
  }
  return left.leftCols(count);
}

Ground::Ground(const Timeline& timeline, const std::vector<NoiseShape>& shapes,
               const SoftBase& base, const Eigen::MatrixXd& series,
               const std::function<bool()>& tick)
    : series_(series),
      spreads_(timeline.spreads()),
      criterion_(static_cast<Eigen::Index>(shapes.size()), series.cols()) {
  const SoftBase independent = independent_base(base);
  spaces_.reserve(shapes.size() * static_cast<std::size_t>(spreads_));
  for (const auto& shape : shapes) {
    if (!spaces_.empty() && tick && !tick()) break;
    for (Eigen::Index g = 0; g < spreads_; ++g)
      spaces_.emplace_back(timeline, shape, independent, g);
    const std::size_t at = left_.size();
    if (spreads_ == 1) {
      left_.push_back(spaces_.back().left_over(series_));
    } else {
      left_.emplace_back(series_.rows(), series_.cols());
      for (Eigen::Index o = 0; o < series.cols(); ++o)
        left_.back().col(o) = space(at, o).left_over(series_.col(o));
    }
    for (Eigen::Index o = 0; o < series.cols(); ++o)
      criterion_(static_cast<Eigen::Index>(at), o) =
          space(at, o).criterion(left_.back().col(o).squaredNorm());
  }
  criterion_.conservativeResize(static_cast<Eigen::Index>(shape_count()), Eigen::NoChange);
  best_ = shared_shape(criterion_).shape;
  priced_ = criterion_;
  for (Eigen::Index s = 0; s < priced_.rows(); ++s)
    priced_.row(s).array() += price_of(shape(static_cast<std::size_t>(s)), outputs());
  auto shared = shared_shape(priced_);
  total_ = shared.total;
  best_priced_ = std::move(shared.shape);
  if (!spaces_.empty())
    alike_ = outputs_alike(correlation(), static_cast<double>(spaces_.front().dof()));
}

WhiteSd Ground::white_sd(Eigen::Index output) const {
  const auto at = best_shape(output);
  return {std::sqrt(left_[at].col(output).squaredNorm() /
                    static_cast<double>(space(at, output).dof()))};
}

WhiteSd Ground::white_sd_with(const Gain& effect, Eigen::Index output) const {
  const auto o = static_cast<std::size_t>(output);
  const std::size_t at = effect.shape[o];
  Eigen::VectorXd left = left_[at].col(output);
  if (effect.contribution[o].size() > 0) left -= effect.contribution[o];
  return {std::sqrt(left.squaredNorm() / static_cast<double>(space(at, output).dof()))};
}

double Ground::worse_by(std::size_t shape, Eigen::Index output) const {
  return criterion_(static_cast<Eigen::Index>(shape), output) -
         criterion_(static_cast<Eigen::Index>(best_shape(output)), output);
}

Eigen::MatrixXd Ground::correlation() const {
  Eigen::MatrixXd left(series_.rows(), series_.cols());
  for (Eigen::Index o = 0; o < series_.cols(); ++o)
    left.col(o) = left_[best_shape(o)].col(o).normalized();
  Eigen::MatrixXd result = left.transpose() * left;
  result.diagonal().setOnes();
  return result;
}

Gain Ground::free_gain(const Eigen::MatrixXd& columns, const std::vector<char>& on) const {
  Gain result;
  const auto count = static_cast<std::size_t>(outputs());
  result.of_output.assign(count, 0);
  result.contribution.resize(count);
  Eigen::MatrixXd with = priced_;
  std::vector<std::vector<Eigen::VectorXd>> contribution(shape_count());
  for (std::size_t s = 0; s < shape_count(); ++s) {
    std::vector<Eigen::MatrixXd> bases;
    for (Eigen::Index g = 0; g < spreads_; ++g) bases.push_back(beyond(in_spread(s, g), columns));
    contribution[s].resize(count);
    for (Eigen::Index o = 0; o < outputs(); ++o) {
      const auto at = static_cast<std::size_t>(o);
      if (on[at] == 0) continue;
      const Eigen::MatrixXd& basis = bases[static_cast<std::size_t>(spread_of(o))];
      const Eigen::VectorXd along = basis.transpose() * left_[s].col(o);
      const double rss = left_[s].col(o).squaredNorm();
      with(static_cast<Eigen::Index>(s), o) =
          space(s, o).criterion(std::max(rss - along.squaredNorm(), kLeast * rss)) +
          price_of(shape(s), outputs());
      contribution[s][at] = basis * along;
    }
  }
  const auto shared = shared_shape(with);
  result.shape = shared.shape;
  for (Eigen::Index o = 0; o < outputs(); ++o) {
    const auto at = static_cast<std::size_t>(o);
    if (on[at] == 0) continue;
    const std::size_t s = shared.shape[at];
    result.of_output[at] = priced_(static_cast<Eigen::Index>(best_priced_[at]), o) -
                           with(static_cast<Eigen::Index>(s), o);
    result.contribution[at] = std::move(contribution[s][at]);
  }
  const Eigen::Map<const Eigen::VectorXd> each(result.of_output.data(), outputs());
  result.likelihood = result.gain = (total_ - shared.total) / counted_times(each, alike_);
  return result;
}

Gain Ground::gain(const Eigen::MatrixXd& columns, const PriorSd& prior) const {
  Gain result;
  const auto count = static_cast<std::size_t>(outputs());
  result.of_output.assign(count, 0);
  result.share.assign(count, 0);
  result.contribution.resize(count);
  Eigen::MatrixXd with = priced_, with_free = priced_;
  Eigen::MatrixXd share = Eigen::MatrixXd::Zero(with.rows(), with.cols());
  std::vector<std::vector<Eigen::VectorXd>> contribution(shape_count());
  const Eigen::MatrixXd centred = columns.rowwise() - columns.colwise().mean();
  const bool may_not_act = (prior.array() > 0).colwise().any().count() > 1;
  for (std::size_t s = 0; s < shape_count(); ++s) {
    const auto row = static_cast<Eigen::Index>(s);
    std::vector<Eigen::MatrixXd> whites;
    for (Eigen::Index g = 0; g < spreads_; ++g) whites.push_back(news_of(in_spread(s, g), centred));
    contribution[s].resize(count);
    for (Eigen::Index o = 0; o < outputs(); ++o) {
      if ((prior.col(o).array() <= 0).all()) continue;
      const Eigen::MatrixXd& white = whites[static_cast<std::size_t>(spread_of(o))];
      const WhitenedSpace& space = this->space(s, o);
      const auto& left = left_[s].col(o);
      const double rss = left.squaredNorm();
      const Eigen::VectorXd along = white.transpose() * left;
      const Eigen::VectorXd width = prior.col(o) / white_sd(o).value;
      const Integrated wide(white, kWidths * width);
      with_free(row, o) = space.criterion(std::max(rss - wide.taken(along), kLeast * rss)) +
                          price_of(space.shape(), outputs());
      ByShare two_ln{};
      double highest = -INFINITY;
      for (std::size_t k = 0; k < kPriorShares.size(); ++k) {
        const Integrated one(white, kPriorShares[k] * width);
        two_ln[k] = criterion_(row, o) -
                    space.criterion(std::max(rss - one.taken(along), kLeast * rss)) -
                    one.log_determinant;
        if (!(two_ln[k] > highest)) continue;
        highest = two_ln[k];
        contribution[s][static_cast<std::size_t>(o)] = white * one.amplitudes(along);
      }
      with(row, o) -= averaged(two_ln, may_not_act);
      share(row, o) = likeliest_share(two_ln, may_not_act);
    }
  }
  const auto shared = shared_shape(with);
  result.shape = shared.shape;
  const auto shared_free = shared_shape(with_free);
  Eigen::VectorXd of_free = Eigen::VectorXd::Zero(outputs());
  for (Eigen::Index o = 0; o < outputs(); ++o) {
    if ((prior.col(o).array() <= 0).all()) continue;
    const auto at = static_cast<std::size_t>(o);
    const auto s = static_cast<Eigen::Index>(shared.shape[at]);
    result.of_output[at] = priced_(static_cast<Eigen::Index>(best_priced_[at]), o) - with(s, o);
    result.share[at] = share(s, o);
    result.contribution[at] = std::move(contribution[shared.shape[at]][at]);
    of_free[o] = priced_(static_cast<Eigen::Index>(best_priced_[at]), o) -
                 with_free(static_cast<Eigen::Index>(shared_free.shape[at]), o);
  }
  const Eigen::Map<const Eigen::VectorXd> each(result.of_output.data(), outputs());
  result.gain = (total_ - shared.total) / counted_times(each, alike_);
  result.likelihood = (total_ - shared_free.total) / counted_times(of_free, alike_);
  return result;
}

Gain Ground::settled_gain(const Eigen::MatrixXd& columns, const PriorSd& prior) const {
  const Gain first = gain(columns, prior);
  PriorSd weighed = prior;
  for (Eigen::Index o = 0; o < outputs(); ++o) {
    const auto at = static_cast<std::size_t>(o);
    if (first.contribution[at].size() == 0) continue;
    const double sd = white_sd_with(first, o).value;
    if (sd > 0) weighed.col(o) *= white_sd(o).value / sd;
  }
  return gain(columns, weighed);
}

Ground::Amplitudes Ground::amplitudes(const Eigen::MatrixXd& columns, const PriorSd& prior,
                                      std::size_t shape, Eigen::Index output) const {
  const Eigen::MatrixXd white =
      space(shape, output).left_over(columns.rowwise() - columns.colwise().mean());
  const auto left = left_[shape].col(output);
  const Eigen::VectorXd along = white.transpose() * left;
  const Integrated first(white, prior.col(output) / white_sd(output).value);
  const double sd =
      std::max((left - white * first.amplitudes(along)).norm(), kLeast * left.norm()) /
      std::sqrt(static_cast<double>(space(shape, output).dof()));
  const Integrated with(white, prior.col(output) / sd);
  Amplitudes result{with.amplitudes(along), {}};
  result.error = sd * with.errors();
  return result;
}

}  // namespace driftwise::diagnosis
