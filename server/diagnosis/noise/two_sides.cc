#include "server/diagnosis/noise/two_sides.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <vector>

#include "server/diagnosis/noise/whitened_space.h"

namespace driftwise::diagnosis {
namespace {

constexpr int kRounds = 60;  // of sides and sizes in turn; a dozen is usual
// Changes of side along a channel, of those that chance makes: one row in 70 strays.
constexpr double kChangesThatTell = 0.06;
constexpr double kFewestShare = 0.1;  // of the rows, on either side
constexpr Eigen::Index kParts = 16;
constexpr std::size_t kSplitsTried = 32;
constexpr double kNothingNew = 1e-6;  // of a squared length: the simulation has these sides already
constexpr double kSoftening = 1e-3;   // of the outputs' mean variance: none is taken for exact

// Alternates between the sizes, by least squares with the sides known, and the side of every row.
class Sides {
 public:
  Sides(const Timeline& timeline, const SoftBase& base, const Eigen::MatrixXd& series)
      : white_(timeline, NoiseShape{0, 1}, base),
        weight_(timeline.sd.size() == 0 ? Eigen::VectorXd(Eigen::VectorXd::Ones(timeline.rows()))
                                        : Eigen::VectorXd(timeline.sd.col(0).cwiseInverse())),
        left_(white_.left_over(series)) {}

  const Eigen::MatrixXd& left() const { return left_; }

  // From a first guess; false: one side is all but empty.
  bool settle(Eigen::VectorXd guess) {
    side_ = signs(guess);
    for (int round = 0; round < kRounds; ++round) {
      if (!resize()) return false;
      // Each row by itself, its side put back.
      const Eigen::MatrixXd alone = about_ + weight_.cwiseProduct(side_) * half_.transpose();
      const Eigen::VectorXd next = signs(alone * along_);
      if (next == side_) break;
      side_ = next;
    }
    return resize();
  }
  // First guesses, for the sizes and the sides in turn only find what is near: each output by
  // itself, what the outputs have in common, and those of the splits of the rows in two, by their
  // order and by each of the simulation's columns, that explain most. A tip keeps its side until
  // something moves it across.
  Eigen::MatrixXd guesses(const SoftBase& base) const {
    const Eigen::VectorXd size = left_.colwise().norm().cwiseMax(1e-300);
    const Eigen::MatrixXd scaled = left_ * size.cwiseInverse().asDiagonal();
    const Eigen::MatrixXd splits = splits_of(base);
    const Eigen::MatrixXd news = white_.left_over(splits);
    Eigen::VectorXd explained(splits.cols());
    for (Eigen::Index k = 0; k < splits.cols(); ++k) {
      const double square = news.col(k).squaredNorm();
      explained[k] = square < kNothingNew * weight_.squaredNorm()
                         ? 0
                         : (scaled.transpose() * news.col(k)).squaredNorm() / square;
    }
    std::vector<Eigen::Index> order(static_cast<std::size_t>(splits.cols()));
    std::iota(order.begin(), order.end(), Eigen::Index{0});
    std::ranges::stable_sort(order, std::ranges::greater{},
                             [&](Eigen::Index k) { return explained[k]; });
    order.resize(std::min<std::size_t>(order.size(), kSplitsTried));
    const Eigen::Index outputs = left_.cols();
    Eigen::MatrixXd result(left_.rows(), outputs + 1 + static_cast<Eigen::Index>(order.size()));
    result.leftCols(outputs) = scaled;
    result.col(outputs) =
        scaled * Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled.transpose() * scaled)
                     .eigenvectors()
                     .rightCols(1);
    for (std::size_t k = 0; k < order.size(); ++k)
      result.col(outputs + 1 + static_cast<Eigen::Index>(k)) = splits.col(order[k]);
    return result;
  }
  const Eigen::VectorXd& side() const { return side_; }
  const Eigen::VectorXd& half() const { return half_; }
  const Eigen::VectorXd& along() const { return along_; }  // the outputs' common part
  double apart() const {
    const Eigen::VectorXd spread = about_ * along_;
    const double sd = std::sqrt(spread.squaredNorm() / static_cast<double>(white_.dof()));
    return 2 * std::abs(half_.dot(along_)) / std::max(sd, 1e-300);
  }

 private:
  static Eigen::VectorXd signs(const Eigen::VectorXd& values) {
    return values.unaryExpr([](double one) { return one < 0 ? -1.0 : 1.0; });
  }
  // The middle of the widest gap between values near one of them, for levels are not cut through.
  static double widest_gap(const std::vector<double>& sorted, std::size_t near, std::size_t reach) {
    std::size_t best = std::max<std::size_t>(near, 1);
    for (std::size_t i = std::max<std::size_t>(near - reach, 1);
         i < std::min(near + reach, sorted.size()); ++i)
      if (sorted[i] - sorted[i - 1] > sorted[best] - sorted[best - 1]) best = i;
    return (sorted[best - 1] + sorted[best]) / 2;
  }
  // By the order of the rows and by each free column, near sixteenths of the rows.
  static Eigen::MatrixXd splits_of(const SoftBase& base) {
    const Eigen::Index rows = base.columns.rows();
    const Eigen::Index variables = 1 + base.free_count();
    Eigen::MatrixXd splits(rows, variables * (kParts - 1));
    for (Eigen::Index v = 0; v < variables; ++v) {
      const Eigen::VectorXd by = v == 0 ? Eigen::VectorXd::LinSpaced(rows, 0, 1)
                                        : Eigen::VectorXd(base.columns.col(v - 1));
      std::vector<double> sorted(by.data(), by.data() + rows);
      std::ranges::sort(sorted);
      for (Eigen::Index k = 1; k < kParts; ++k) {
        const double cut = widest_gap(sorted, static_cast<std::size_t>(rows * k / kParts),
                                      static_cast<std::size_t>(rows / (2 * kParts)));
        splits.col(v * (kParts - 1) + k - 1) =
            by.unaryExpr([cut](double one) { return one > cut ? 1.0 : -1.0; });
      }
    }
    return splits;
  }
  bool resize() {
    const auto rows = static_cast<double>(side_.size());
    const double up = (rows + side_.sum()) / 2;
    if (std::min(up, rows - up) < kFewestShare * rows) return false;
    const Eigen::VectorXd column = white_.left_over(side_);
    const double square = column.squaredNorm();
    if (square < kNothingNew * weight_.squaredNorm()) return false;
    half_ = left_.transpose() * column / square;
    about_ = left_ - column * half_.transpose();
    Eigen::MatrixXd spread = about_.transpose() * about_;
    spread.diagonal().array() +=
        kSoftening * spread.trace() / static_cast<double>(spread.cols()) + 1e-300;
    along_ = spread.ldlt().solve(half_);
    along_ /= std::max(along_.norm(), 1e-300);
    return true;
  }

  WhitenedSpace white_;
  Eigen::VectorXd weight_;
  Eigen::MatrixXd left_, about_;  // what is left without the sides, and with them; whitened
  Eigen::VectorXd side_, half_, along_;
};

// In the order of a channel the side hardly ever changes: something at those places, or under that
// load, and no side.
bool is_told_by(const Eigen::MatrixXd& channels, const Eigen::VectorXd& side) {
  const double mean = side.mean();
  const double by_chance = (1 - mean * mean) / 2 * static_cast<double>(side.size() - 1);
  std::vector<Eigen::Index> order(static_cast<std::size_t>(side.size()));
  for (const auto& channel : channels.colwise()) {
    std::iota(order.begin(), order.end(), Eigen::Index{0});
    std::ranges::stable_sort(order, {}, [&](Eigen::Index i) { return channel[i]; });
    double changes = 0;
    for (std::size_t k = 1; k < order.size(); ++k)
      changes += side[order[k]] != side[order[k - 1]] ? 1 : 0;
    if (changes < kChangesThatTell * by_chance) return true;
  }
  return false;
}

}  // namespace

std::optional<TwoSides> two_sides(const Timeline& given, const SoftBase& simulation,
                                  const Eigen::MatrixXd& series, const Eigen::MatrixXd& channels) {
  const Timeline timeline = given.with_one_spread();  // a row's side is one for all outputs
  const SoftBase base = independent_base(simulation);
  Sides sides(timeline, base, series);
  const Eigen::MatrixXd guesses = sides.guesses(base);
  std::optional<TwoSides> best;
  for (const auto& guess : guesses.colwise()) {
    if (!sides.settle(guess) || sides.apart() < std::max(kSidesApart, best ? best->apart : 0))
      continue;
    best = TwoSides{sides.side(), sides.half(), sides.along(), sides.apart(), 0, 0};
  }
  if (!best || is_told_by(channels, best->side)) return {};
  // The outputs' common part, then each output.
  Eigen::MatrixXd before(series.rows(), series.cols() + 1), after;
  before << series * best->along, series;
  Eigen::VectorXd half(series.cols() + 1);
  half << best->half.dot(best->along), best->half;
  after = before - best->side * half.transpose();
  Eigen::VectorXd lowest_before = Eigen::VectorXd::Constant(half.size(), INFINITY),
                  lowest_after = lowest_before;
  for (const auto& shape : noise_grid(timeline)) {
    const WhitenedSpace space(timeline, shape, base);
    const Eigen::VectorXd squares_before = space.left_over(before).colwise().squaredNorm(),
                          squares_after = space.left_over(after).colwise().squaredNorm();
    for (Eigen::Index k = 0; k < half.size(); ++k) {
      lowest_before[k] = std::min(lowest_before[k], space.criterion(squares_before[k]));
      lowest_after[k] = std::min(lowest_after[k], space.criterion(squares_after[k]));
    }
  }
  const double price = 2 * std::numbers::ln2 * static_cast<double>(timeline.rows());
  const Eigen::VectorXd growth = lowest_before - lowest_after;
  best->gain = growth[0] - price;
  best->evidence = growth.tail(series.cols()).sum() - price;
  if (!(best->gain > 0)) return {};
  return best;
}

}  // namespace driftwise::diagnosis
