#include "server/diagnosis/rows/coarse_readings.h"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>

#include "server/core/text/quantity_text.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::size_t kFewestReadings = 16;
constexpr double kStandsStill = 0.5;        // share of the rows
constexpr double kWholeStep = 1e-3;         // of a step, off a whole number of steps
constexpr double kShortest = 1e-3;          // of a typical distance in time, between two rows
constexpr Eigen::Index kMostChosen = 4000;  // rows that rate and noise are chosen on
// Scale of the reading's own noise (logistic), in steps: beyond the largest a display does not
// stand still in half of the rows.
constexpr std::array<double, 3> kNoises = {0.05, 0.1, 0.2};
// Departure of the course from a straight line in the time of one step, in steps.
constexpr std::array<double, 7> kBends = {0.01, 0.03, 0.1, 0.3, 1, 3, 10};
constexpr int kMostRounds = 100;
constexpr double kRidge = 1e-9;   // of a precision, steps^-2
constexpr double kEnough = 1e-8;  // of the objective, to be had by another round
constexpr double kLeastStride = 1e-4;
constexpr Eigen::Index kUncertainties = 24, kBeyond = 8;  // directions looked for besides
constexpr int kPowers = 3;
constexpr double kRuledOut = 4;          // in ln L, below the likeliest
constexpr double kLeastVariance = 1e-3;  // of an uncertainty, over the largest

double softplus(double v) { return v > 0 ? v + std::log1p(std::exp(-v)) : std::log1p(std::exp(v)); }
double sigmoid(double v) { return 1 / (1 + std::exp(-v)); }

// A symmetric matrix with two diagonals beside the main one, and its factors L D L'.
struct Band {
  Eigen::VectorXd own, next, second;

  explicit Band(Eigen::Index n)
      : own(Eigen::VectorXd::Zero(n)),
        next(Eigen::VectorXd::Zero(n)),
        second(Eigen::VectorXd::Zero(n)) {}

  Eigen::VectorXd times(const Eigen::VectorXd& v) const {
    const Eigen::Index n = v.size();
    Eigen::VectorXd result = own.cwiseProduct(v);
    for (Eigen::Index i = 0; i + 1 < n; ++i) {
      result[i] += next[i] * v[i + 1];
      result[i + 1] += next[i] * v[i];
    }
    for (Eigen::Index i = 0; i + 2 < n; ++i) {
      result[i] += second[i] * v[i + 2];
      result[i + 2] += second[i] * v[i];
    }
    return result;
  }
  // In place. Returns the log determinant.
  double factor() {
    double log_determinant = 0;
    const Eigen::Index n = own.size();
    for (Eigen::Index i = 0; i < n; ++i) {
      log_determinant += std::log(own[i]);
      const double a = next[i], b = second[i];
      if (i + 1 < n) {
        own[i + 1] -= a * a / own[i];
        next[i + 1] -= a * b / own[i];
      }
      if (i + 2 < n) own[i + 2] -= b * b / own[i];
      next[i] = a / own[i];
      second[i] = b / own[i];
    }
    return log_determinant;
  }
  // By the factors.
  Eigen::VectorXd solve(Eigen::VectorXd v) const {
    const Eigen::Index n = v.size();
    for (Eigen::Index i = 0; i < n; ++i) {
      if (i + 1 < n) v[i + 1] -= next[i] * v[i];
      if (i + 2 < n) v[i + 2] -= second[i] * v[i];
    }
    v.array() /= own.array();
    for (Eigen::Index i = n; i-- > 0;) {
      if (i + 1 < n) v[i] -= next[i] * v[i + 1];
      if (i + 2 < n) v[i] -= second[i] * v[i + 2];
    }
    return v;
  }
};

// Readings in steps about their middle, time in units of the time between two steps.
class Rounded {
 public:
  Rounded(const Eigen::VectorXd& time, Eigen::VectorXd readings)
      : readings_(std::move(readings)), bending_(readings_.size()) {
    for (Eigen::Index i = 0; i + 2 < readings_.size(); ++i) {
      const double before = time[i + 1] - time[i], after = time[i + 2] - time[i + 1];
      const double weight = 1 / std::sqrt((before + after) / 2);
      const Eigen::Vector3d change(weight / before, -weight / before - weight / after,
                                   weight / after);
      for (Eigen::Index k = 0; k < 3; ++k) bending_.own[i + k] += change[k] * change[k];
      bending_.next[i] += change[0] * change[1];
      bending_.next[i + 1] += change[1] * change[2];
      bending_.second[i] += change[0] * change[2];
    }
  }

  // The likeliest course, from the one given; the log of the marginal likelihood but a constant.
  double find(double noise, double bend, Eigen::VectorXd& course) const {
    const auto n = static_cast<double>(readings_.size());
    double now = objective(noise, bend, course), log_determinant = 0;
    for (int round = 0; round < kMostRounds; ++round) {
      Band curvature = stiffness(bend);
      Eigen::VectorXd slope = bending_.times(course) / (bend * bend);
      for (Eigen::Index i = 0; i < course.size(); ++i) {
        const double above = sigmoid((course[i] - readings_[i] - 0.5) / noise);
        const double below = sigmoid((readings_[i] - 0.5 - course[i]) / noise);
        slope[i] += (above - below) / noise;
        curvature.own[i] += (above * (1 - above) + below * (1 - below)) / (noise * noise) + kRidge;
      }
      log_determinant = curvature.factor();
      const Eigen::VectorXd way = curvature.solve(slope);
      double stride = 1, then = INFINITY;
      for (; stride > kLeastStride; stride /= 2) {
        then = objective(noise, bend, course - stride * way);
        if (then < now) break;
      }
      if (!(then < now)) break;
      course -= stride * way;
      const bool enough = now - then < kEnough * (1 + std::abs(now));
      now = then;
      if (enough) break;
    }
    return -now + n * std::log1p(-std::exp(-1 / noise)) - (n - 2) * std::log(bend) -
           log_determinant / 2;
  }

  // The largest directions of its Laplace covariance, each as long as its standard deviation; by
  // powers of the covariance applied to random directions.
  Eigen::MatrixXd unsure(double noise, double bend, const Eigen::VectorXd& course) const {
    Band precision = stiffness(bend);
    for (Eigen::Index i = 0; i < course.size(); ++i) {
      const double above = sigmoid((course[i] - readings_[i] - 0.5) / noise);
      const double below = sigmoid((readings_[i] - 0.5 - course[i]) / noise);
      precision.own[i] += (above * (1 - above) + below * (1 - below)) / (noise * noise) + kRidge;
    }
    precision.factor();
    const auto covariance_times = [&](const Eigen::MatrixXd& columns) {
      Eigen::MatrixXd result(columns.rows(), columns.cols());
      for (Eigen::Index k = 0; k < columns.cols(); ++k)
        result.col(k) = precision.solve(columns.col(k));
      return result;
    };
    const Eigen::Index n = course.size(), count = std::min(kUncertainties + kBeyond, n);
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal;
    Eigen::MatrixXd space = Eigen::MatrixXd::NullaryExpr(n, count, [&] { return normal(random); });
    for (int power = 0; power < kPowers; ++power) {
      const Eigen::HouseholderQR<Eigen::MatrixXd> qr(covariance_times(space));
      space = qr.householderQ() * Eigen::MatrixXd::Identity(n, count);
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> own(space.transpose() *
                                                             covariance_times(space));
    const Eigen::VectorXd variances = own.eigenvalues().cwiseMax(0);
    Eigen::Index kept = 0;
    while (kept < std::min(count, kUncertainties) &&
           variances[count - 1 - kept] > kLeastVariance * variances[count - 1])
      ++kept;
    return space * own.eigenvectors().rightCols(kept) *
           variances.tail(kept).cwiseSqrt().asDiagonal();
  }

 private:
  Band stiffness(double bend) const {
    Band result = bending_;
    for (auto* diagonal : {&result.own, &result.next, &result.second}) *diagonal /= bend * bend;
    return result;
  }
  double objective(double noise, double bend, const Eigen::VectorXd& course) const {
    double sum = course.dot(bending_.times(course)) / (2 * bend * bend);
    for (Eigen::Index i = 0; i < course.size(); ++i)
      sum += softplus((course[i] - readings_[i] - 0.5) / noise) +
             softplus((readings_[i] - 0.5 - course[i]) / noise);
    return sum;
  }

  Eigen::VectorXd readings_;
  Band bending_;
};

struct Likely {
  double noise = 0, bend = 0, weight = 0;
};

// Those that the readings do not rule out, weights in proportion to their likelihoods. On the first
// rows, where there are many.
std::vector<Likely> likely_priors(const Eigen::VectorXd& time, const Eigen::VectorXd& readings) {
  const Eigen::Index rows = std::min(time.size(), kMostChosen);
  const Rounded sample(time.head(rows), readings.head(rows));
  std::vector<Likely> all;
  double best = -INFINITY;
  for (const double noise : kNoises) {
    Eigen::VectorXd course = readings.head(rows);
    for (std::size_t k = kBends.size(); k-- > 0;) {  // from loose to stiff
      all.push_back({noise, kBends[k], sample.find(noise, kBends[k], course)});
      best = std::max(best, all.back().weight);
    }
  }
  std::erase_if(all, [best](const Likely& one) { return !(one.weight > best - kRuledOut); });
  double sum = 0;
  for (auto& one : all) sum += one.weight = std::exp(one.weight - best);
  for (auto& one : all) one.weight /= sum;
  return all;
}

// The same covariance in fewer columns, the largest first.
Eigen::MatrixXd largest_directions(const Eigen::MatrixXd& columns) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> own(columns.transpose() * columns);
  const Eigen::Index count = columns.cols();
  const double largest = own.eigenvalues()[count - 1];
  Eigen::Index kept = 0;
  while (kept < std::min(count, kUncertainties) &&
         own.eigenvalues()[count - 1 - kept] > kLeastVariance * largest)
    ++kept;
  return columns * own.eigenvectors().rightCols(kept).rowwise().reverse();
}

std::optional<double> widest_step(const Channel& channel) {
  constexpr double kPressure_hPa = 1, kHumidity_pct = 1;
  if (is_structure_temperature(channel) || channel.symbol == "air") return kWidestDisplay_K;
  if (channel.symbol == "pressure") return kPressure_hPa;
  if (channel.symbol == "humidity") return kHumidity_pct;
  return std::nullopt;
}

}  // namespace

double display_step(const std::vector<double>& values, double widest) {
  std::vector<double> changes;
  double before = NAN;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    if (std::isfinite(before)) changes.push_back(std::abs(value - before));
    before = value;
  }
  if (changes.size() + 1 < kFewestReadings) return 0;
  double step = INFINITY;
  const double least = kWholeStep * widest;  // a conversion of units leaves rounding errors
  for (const double change : changes)
    if (change > least) step = std::min(step, change);
  if (!(step <= widest * (1 + kWholeStep))) return 0;
  std::size_t still = 0;
  for (const double change : changes) {
    if (std::abs(change - step * std::round(change / step)) > kWholeStep * step) return 0;
    still += change <= least ? 1 : 0;
  }
  return static_cast<double>(still) >= kStandsStill * static_cast<double>(changes.size()) ? step
                                                                                          : 0;
}

Course between_steps(std::span<const double> time_s, const std::vector<double>& values,
                     double step) {
  Course result{values, Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(values.size()), 0)};
  std::vector<std::size_t> present;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (std::isfinite(values[i])) present.push_back(i);
  const auto n = static_cast<Eigen::Index>(present.size());
  if (n < static_cast<Eigen::Index>(kFewestReadings) || !(step > 0)) return result;
  const double middle = values[present[present.size() / 2]];
  Eigen::VectorXd time(n), readings(n);
  double steps = 0;
  std::vector<double> distances;
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::size_t row = present[static_cast<std::size_t>(i)];
    time[i] = time_s[row];
    readings[i] = std::round((values[row] - middle) / step);
    if (i == 0) continue;
    distances.push_back(time[i] - time[i - 1]);
    steps += std::abs(readings[i] - readings[i - 1]);
  }
  const double whole_s = time[n - 1] - time[0];
  const auto half = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::ranges::nth_element(distances, half);
  const double shortest = kShortest * (*half > 0 ? *half : whole_s / static_cast<double>(n));
  if (!(shortest > 0) || !(steps > 0)) return result;
  double shift = 0, last = time[0];
  for (Eigen::Index i = 1; i < n; ++i) {  // no two rows at the same instant
    shift += std::max(shortest - (time[i] - last), 0.0);
    last = time[i];
    time[i] += shift;
  }
  time /= whole_s / steps;

  const std::vector<Likely> likely = likely_priors(time, readings);
  const Rounded all(time, readings);
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(n);
  std::vector<Eigen::VectorXd> courses;
  for (const auto& one : likely) {
    courses.push_back(readings);
    all.find(one.noise, one.bend, courses.back());
    mean += one.weight * courses.back();
  }
  Eigen::MatrixXd unsure(n, 0);
  for (std::size_t k = 0; k < likely.size(); ++k) {
    const auto& [noise, bend, weight] = likely[k];
    const Eigen::MatrixXd own = all.unsure(noise, bend, courses[k]);
    const Eigen::MatrixXd before = unsure;
    unsure.resize(n, before.cols() + own.cols() + 1);
    unsure << before, std::sqrt(weight) * own, std::sqrt(weight) * (courses[k] - mean);
  }
  unsure = step * largest_directions(unsure);
  result.unsure.setZero(result.unsure.rows(), unsure.cols());
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::size_t row = present[static_cast<std::size_t>(i)];
    result.values[row] = middle + step * mean[i];
    result.unsure.row(static_cast<Eigen::Index>(row)) = unsure.row(i);
  }
  return result;
}

std::map<std::string, CoarseChannel> estimate_between_steps(Dataset& data) {
  std::vector<double> clock = data.time_s;
  if (clock.empty())
    for (std::size_t i = 0; i < data.rows; ++i) clock.push_back(static_cast<double>(i));
  std::map<std::string, CoarseChannel> coarse;
  for (auto& [channel, values] : data.columns) {
    const auto widest = widest_step(channel);
    if (!widest) continue;
    const double step = display_step(values, *widest);
    if (!(step > 0)) continue;
    Course course = between_steps(clock, values, step);
    values = std::move(course.values);
    coarse[channel.symbol] = {step, std::move(course.unsure)};
  }
  return coarse;
}

std::vector<std::string> coarse_notes(const std::map<std::string, CoarseChannel>& coarse) {
  constexpr std::size_t kMostNamed = 3;
  std::map<std::string, std::vector<std::string>> by_step;
  for (const auto& [symbol, channel] : coarse) {
    const char* unit = symbol == "pressure" ? " hPa" : symbol == "humidity" ? " %" : " K";
    by_step[digits_text(channel.step) + unit].push_back(symbol);
  }
  std::vector<std::string> notes;
  for (const auto& [step, symbols] : by_step) {
    const std::size_t named = symbols.size() > kMostNamed + 1 ? kMostNamed : symbols.size();
    std::string text;
    for (std::size_t i = 0; i < named; ++i)
      text += (i == 0 ? "" : i + 1 == symbols.size() ? " and " : ", ") + symbols[i];
    if (named < symbols.size())
      text += " and " + std::to_string(symbols.size() - named) + " others";
    notes.push_back(text + (symbols.size() == 1 ? " is" : " are") + " read in steps of " + step +
                    (symbols.size() == 1 ? ": its course" : ": their course") +
                    " between them is estimated");
  }
  return notes;
}

}  // namespace driftwise::diagnosis
