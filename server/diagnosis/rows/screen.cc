#include "server/diagnosis/rows/screen.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "server/diagnosis/noise/own_rows.h"
#include "server/diagnosis/noise/robust.h"
#include "server/diagnosis/noise/tails.h"
#include "server/diagnosis/rows/held_out_gain.h"
#include "server/diagnosis/rows/places.h"
#include "server/diagnosis/rows/sensor_changes.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kWrongRow = 8, kAgree = 4;  // robust standard deviations
constexpr double kMostWrongRows = 0.05;
constexpr std::size_t kLongestRun = 4;  // of wrong rows; what lasts longer is an event
constexpr double kBetween = 4.5;     // robust standard deviations: 1 row of 150 000 of normal noise
constexpr std::size_t kNearby = 40;  // rows to either side in time that tell the spread there
constexpr std::size_t kBeside = 3;   // rows to either side in position
constexpr double kOwn = 0.5;         // of a wrong row, beyond what those beside it share
constexpr double kSurelyGross = 0.9;   // posterior
constexpr Eigen::Index kNearRows = 3;  // rows apart: what two of them share lasts longer than a row
// A spread that grows little by little with the hour does so in all outputs, and is no change at an
// instant: a third of the gain again for each of them, where chance alone would take 3.4.
// An output has a change that others have where it gains as much itself: at one instant, 1 in 600
// by chance.
constexpr double kNoiseChangeGain = 30, kOfFurtherOutput = 10;
constexpr double kMostSquare = 9;  // of a square, in units of its usual size
constexpr Eigen::Index kFewestEachSide = 25;

// The spread of the values, and nowhere less than that of those nearby: gusts are no wrong rows.
std::vector<double> spreads(const std::vector<double>& values) {
  const double everywhere = robust_sd(values);
  std::vector<double> result(values.size(), everywhere);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t from = i > kNearby ? i - kNearby : 0;
    const std::size_t to = std::min(values.size(), i + kNearby + 1);
    result[i] = std::max(everywhere, robust_sd({values.begin() + static_cast<std::ptrdiff_t>(from),
                                                values.begin() + static_cast<std::ptrdiff_t>(to)}));
  }
  return result;
}

// Each row's residual as those measured beside it have it in the middle: at the same place, or at
// the nearest. Something that they share is wrong with the place, not with a row.
std::vector<double> as_beside(const Problem& problem, const std::vector<std::size_t>& rows,
                              const std::vector<double>& left) {
  std::vector<std::vector<double>> axes;
  for (const auto& column : problem.data().columns)
    if (is_coordinate(problem, column.channel) &&
        std::ranges::all_of(rows, [&](std::size_t i) { return std::isfinite(column.values[i]); }))
      axes.push_back(by_places(column.values));
  std::vector<double> result(rows.size(), 0);
  if (axes.empty()) return result;
  std::vector<std::size_t> order(rows.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) {
    for (const auto& axis : axes)
      if (axis[rows[a]] != axis[rows[b]]) return axis[rows[a]] < axis[rows[b]];
    return false;
  });
  for (std::size_t i = 0; i < order.size(); ++i) {
    std::vector<double> beside;
    for (std::size_t k = i > kBeside ? i - kBeside : 0; k < std::min(i + kBeside + 1, order.size());
         ++k)
      if (k != i) beside.push_back(left[order[k]]);
    result[order[i]] = median(std::move(beside));
  }
  return result;
}

// Rows of which the machine may have changed before: after a pause, or with a new zero.
std::vector<char> breaks_of(const Dataset& data) {
  std::vector<char> result = after_a_pause(data);
  for (std::size_t i = 1; i < data.datum.size(); ++i)
    if (data.datum[i] != data.datum[i - 1]) result[i] = 1;
  return result;
}

// Rows one after the other that lie off the one before them and the one after, which agree; all to
// one side, for where a smoothed temperature cuts a corner rows lie off to both.
struct RunOff {
  std::size_t first = 0, count = 0;
  double beside = 0;  // mean of the two
};

// left: of every row of the dataset. least, agree: of the rows' index.
template <typename Least, typename Agree>
std::vector<RunOff> runs_off(const Eigen::VectorXd& left, const Least& least, const Agree& agree,
                             const std::vector<std::size_t>& rows,
                             const std::vector<char>& after_a_break) {
  const auto at = [&](std::size_t i) { return left[static_cast<Eigen::Index>(rows[i])]; };
  std::vector<RunOff> runs;
  for (std::size_t i = 1; i + 1 < rows.size(); ++i) {
    const auto is_run = [&](std::size_t count) {
      const double before = at(i - 1), after = at(i + count), beside = (before + after) / 2;
      const int breaks =
          (after_a_break[rows[i]] != 0 ? 1 : 0) + (after_a_break[rows[i + count]] != 0 ? 1 : 0);
      if (breaks > (count > 1 ? 0 : 1)) return false;  // the machine was another one meanwhile
      for (std::size_t k = i; k < i + count; ++k)
        if (!(std::min(std::abs(at(k) - before), std::abs(at(k) - after)) > least(k)) ||
            std::signbit(at(k) - beside) != std::signbit(at(i) - beside))
          return false;
      return std::abs(after - before) < agree(i);
    };
    for (std::size_t count = 1; count <= kLongestRun && i + count < rows.size(); ++count) {
      if (!is_run(count)) continue;
      runs.push_back({i, count, (at(i - 1) + at(i + count)) / 2});
      i += count;  // the row after it is right
      break;
    }
  }
  return runs;
}

// Wrong rows are a population of their own: between them and the noise there is next to nothing.
// Where as many rows lie half as far off, the noise itself has heavy tails.
bool tails_are_heavy(const Problem& problem, const std::vector<std::size_t>& rows,
                     const std::set<std::size_t>& wrong) {
  std::size_t between = 0;
  for (const auto& output : problem.outputs) {
    const Eigen::VectorXd left = residuals(problem, output, problem.base_columns);
    std::vector<double> about;
    for (const std::size_t row : rows) about.push_back(left[static_cast<Eigen::Index>(row)]);
    const double middle = median(about);
    for (double& one : about) one -= middle;
    const double sd = robust_sd(about);
    for (std::size_t i = 0; i < rows.size(); ++i)
      between += !wrong.contains(rows[i]) && std::abs(about[i]) > kBetween * sd ? 1 : 0;
  }
  return between > std::max<std::size_t>(1, wrong.size() / 3);
}

}  // namespace

std::vector<OutlierRow> outlier_rows(const Problem& problem, double alpha) {
  std::vector<OutlierRow> found;
  double p = 1;
  std::vector<std::size_t> rows = problem.learn;
  rows.insert(rows.end(), problem.judge.begin(), problem.judge.end());
  std::ranges::sort(rows);
  rows.erase(std::ranges::unique(rows).begin(), rows.end());
  std::set<std::size_t> wrong;
  const auto breaks = breaks_of(problem.data());
  for (const auto& output : problem.outputs) {
    const Eigen::VectorXd left = residuals(problem, output, problem.base_columns);
    const auto at = [&](std::size_t i) { return left[static_cast<Eigen::Index>(rows[i])]; };
    std::vector<double> apart(rows.size(), 0), across(rows.size(), 0);
    for (std::size_t i = 1; i + 1 < rows.size(); ++i) {
      apart[i] = at(i) - (at(i - 1) + at(i + 1)) / 2;
      across[i] = at(i + 1) - at(i - 1);
    }
    const auto sd = spreads(apart), sd_across = spreads(across);
    std::vector<double> about;
    for (std::size_t i = 0; i < rows.size(); ++i) about.push_back(at(i));
    const double middle = median(about);
    for (double& one : about) one -= middle;
    const double least = kWrongRow * robust_sd(about);  // slow noise has close neighbours
    const auto beside = as_beside(problem, rows, about);
    const auto is_own = [&](std::size_t i) {
      return sd[i] > 0 && std::abs(about[i] - beside[i]) >= kOwn * std::abs(about[i]);
    };
    const auto runs = runs_off(
        left, [&](std::size_t i) { return std::max(kWrongRow * sd[i], least); },
        [&](std::size_t i) { return kAgree * sd_across[i]; }, rows, breaks);
    std::vector<char> of_this(rows.size(), 0);
    double nearest = INFINITY;
    std::size_t count = 0;
    for (const RunOff& run : runs) {
      bool all_own = true;
      for (std::size_t i = run.first; i < run.first + run.count; ++i)
        all_own = all_own && is_own(i);
      if (!all_own) continue;
      for (std::size_t i = run.first; i < run.first + run.count; ++i) {
        const double off = std::abs(at(i) - run.beside);
        nearest = std::min({nearest, off, std::abs(about[i])});
        ++count;
        of_this[i] = 1;
        found.push_back({rows[i], output.channel.symbol});
        wrong.insert(rows[i]);
      }
    }
    if (count == 0) continue;
    // The rows themselves: a row less its neighbours has lighter tails than the row.
    std::vector<double> others;
    for (std::size_t i = 0; i < rows.size(); ++i)
      if (of_this[i] == 0) others.push_back(about[i]);
    const double chance = student_law(others, 0).beyond(nearest);
    p = std::min(p, static_cast<double>(problem.outputs.size()) *
                        chance_of_as_many(chance, count, rows.size()));
  }
  if (p > alpha || tails_are_heavy(problem, rows, wrong)) return {};
  for (auto& one : found) one.p = p;
  if (static_cast<double>(wrong.size()) > kMostWrongRows * static_cast<double>(rows.size()))
    return {};
  std::ranges::stable_sort(found, {}, &OutlierRow::row);
  return found;
}

std::vector<OutlierRow> gross_errors(const Problem& problem, const Ground& ground, double alpha) {
  std::vector<OutlierRow> found;
  if (problem.rows_per_block > 1) return found;
  std::vector<Eigen::VectorXd> left_of;
  std::vector<Tails> tails;
  for (Eigen::Index o = 0; o < ground.outputs(); ++o) {
    const WhitenedSpace& space = ground.space(ground.best_shape(o), o);
    left_of.emplace_back(own_rows(space, space.left_over(ground.series().col(o))).off);
    tails.emplace_back(left_of.back());
  }
  for (Eigen::Index o = 0; o < ground.outputs(); ++o) {
    const auto at_output = static_cast<std::size_t>(o);
    const Eigen::VectorXd& left = left_of[at_output];
    const GrossGain best = gross_gain(tails, at_output);
    if (best.gain < 2 * std::log(kTailFrom / alpha)) continue;
    const double p = chance_of_gross(tails, left.size(), best.gain);
    if (p > alpha) continue;
    const Eigen::ArrayXd& gross = tails[at_output].gross(best.freedom);
    const std::vector<double> values(left.data(), left.data() + left.size());
    const auto beside = as_beside(problem, problem.learn, values);
    std::vector<Eigen::Index> off;
    for (Eigen::Index i = 0; i < left.size(); ++i)
      if (gross[i] >= kSurelyGross) off.push_back(i);
    const auto wrong =
        beyond_the_farther(ground.space(ground.best_shape(o), o), left, std::move(off));
    std::vector<OutlierRow> rows;
    for (std::size_t k = 0; k < wrong.size(); ++k) {
      const Eigen::Index i = wrong[k];
      const auto at = static_cast<std::size_t>(i);
      const bool near_another = (k > 0 && i - wrong[k - 1] <= kNearRows) ||
                                (k + 1 < wrong.size() && wrong[k + 1] - i <= kNearRows);
      if (!near_another && std::abs(left[i] - beside[at]) >= kOwn * std::abs(left[i]))
        rows.push_back({problem.learn[at], problem.outputs[at_output].channel.symbol, p});
    }
    // Errors that neighbours in time or place share are no row's; where most do, none is.
    if (2 * rows.size() > wrong.size()) found.insert(found.end(), rows.begin(), rows.end());
  }
  std::ranges::stable_sort(found, {}, &OutlierRow::row);
  return found;
}

namespace {

// A display of few levels shows one of them in half of the rows, and their middle says nothing of
// the spread: what nine in ten rows keep within has a say too.
double usual_spread(const Eigen::Ref<const Eigen::VectorXd>& left) {
  constexpr double kShare = 0.9, kOfNormal = 1.645;
  std::vector<double> sizes(left.data(), left.data() + left.size());
  for (double& size : sizes) size = std::abs(size);
  const auto at =
      sizes.begin() + static_cast<std::ptrdiff_t>(kShare * static_cast<double>(sizes.size() - 1));
  std::nth_element(sizes.begin(), at, sizes.end());
  const double of_most = *at / kOfNormal;
  return std::max(robust_sd(std::move(sizes)), of_most);
}

// Each in units of its usual spread, and back.
Eigen::VectorXd clipped_squares(const Eigen::VectorXd& left) {
  const double sd = usual_spread(left);
  if (!(sd > 0)) return left.cwiseAbs2();
  return sd * sd * (left / sd).cwiseAbs2().cwiseMin(kMostSquare);
}

// 2 ln L of two spreads over one: numbers of squares and their sums.
double sides_gain(Eigen::Index n1, double sum1, Eigen::Index n2, double sum2) {
  const auto a = static_cast<double>(n1), b = static_cast<double>(n2);
  return (a + b) * std::log((sum1 + sum2) / (a + b)) - a * std::log(sum1 / a) -
         b * std::log(sum2 / b);
}

// Residual of one output, whitened.
struct Spreading {
  std::size_t output;
  Eigen::VectorXd left, clipped;  // in units of its spread; squares
};

// 2 ln L of two spreads, for every number of rows before the change: 0 where a side has too few.
Eigen::VectorXd gains_of_sides(const Spreading& one) {
  const Eigen::Index n = one.clipped.size();
  Eigen::VectorXd gains = Eigen::VectorXd::Zero(n);
  const double whole = one.clipped.sum();
  double before = 0;
  for (Eigen::Index k = 1; k + kFewestEachSide <= n; ++k) {
    before += one.clipped[k - 1];
    if (k >= kFewestEachSide) gains[k] = sides_gain(k, before, n - k, whole - before);
  }
  return gains;
}

NoiseChange change_at(const Spreading& one, Eigen::Index at) {
  const Eigen::Index n = one.left.size();
  // Squares clipped by the common spread found the instant; by either side's own they weigh it.
  const Eigen::VectorXd first = clipped_squares(one.left.head(at)),
                        second = clipped_squares(one.left.tail(n - at));
  const double v1 = first.mean(), v2 = second.mean();
  // Scatter of the squares about either side's own spread: 2 where the sides are normal. About
  // the common spread two sides would count as tails.
  const double scatter =
      ((first / v1).array() - 1).square().sum() + ((second / v2).array() - 1).square().sum();
  const double gain = sides_gain(at, first.sum(), n - at, second.sum()) /
                      std::max(scatter / static_cast<double>(n) / 2, 1.0);
  return {one.output, at, std::sqrt(v2 / v1), gain, gain};
}

// Of all outputs at the instant that suits them best together; none where chance does as well.
std::vector<NoiseChange> changes_together(const std::vector<Spreading>& outputs,
                                          const Ground& ground) {
  if (outputs.size() < 2) return {};
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(outputs.front().clipped.size());
  for (const auto& one : outputs) sum += gains_of_sides(one);
  Eigen::Index at = 0;
  if (!(sum.maxCoeff(&at) > 0)) return {};
  std::vector<NoiseChange> changes;
  Eigen::VectorXd gains = Eigen::VectorXd::Zero(ground.outputs());
  for (const auto& one : outputs) {
    changes.push_back(change_at(one, at));
    gains[static_cast<Eigen::Index>(one.output)] = std::max(changes.back().gain, 0.0);
  }
  const double together = gains.sum() / counted_times(gains, ground.alike());
  const double rare = kNoiseChangeGain + kOfFurtherOutput * static_cast<double>(gains.size() - 1);
  if (together < rare) return {};
  for (auto& change : changes) change.together = together;
  std::erase_if(changes, [](const NoiseChange& one) { return one.gain < kOfFurtherOutput; });
  return changes;
}

double sum_of_gains(const std::vector<NoiseChange>& changes) {
  double sum = 0;
  for (const auto& one : changes) sum += one.gain;
  return sum;
}

}  // namespace

std::vector<NoiseChange> noise_changes(const Ground& ground) {
  std::vector<Spreading> outputs;
  std::vector<NoiseChange> found;
  for (Eigen::Index o = 0; o < ground.outputs(); ++o) {
    Eigen::VectorXd left = ground.space(ground.best_shape(o), o).left_over(ground.series().col(o));
    const double sd = usual_spread(left);
    if (!(sd > 0)) continue;
    // A heavy tail is no change.
    Eigen::VectorXd clipped = (left / sd).cwiseAbs2().cwiseMin(kMostSquare);
    outputs.push_back({static_cast<std::size_t>(o), std::move(left), std::move(clipped)});
    Eigen::Index at = 0;
    if (!(gains_of_sides(outputs.back()).maxCoeff(&at) > 0)) continue;
    const auto best = change_at(outputs.back(), at);
    if (best.gain > kNoiseChangeGain) found.push_back(best);
  }
  auto together = changes_together(outputs, ground);
  const bool more = together.size() > found.size() && sum_of_gains(together) > sum_of_gains(found);
  return more ? together : found;
}

}  // namespace driftwise::diagnosis
