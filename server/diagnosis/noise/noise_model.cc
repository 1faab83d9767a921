#include "server/diagnosis/noise/noise_model.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace driftwise::diagnosis {
namespace {

double typical_step_s(const Timeline& timeline) {
  std::vector<double> steps;
  for (Eigen::Index i = 1; i < timeline.rows(); ++i)
    if (timeline.restart[static_cast<std::size_t>(i)] == 0)
      steps.push_back(timeline.time_s[i] - timeline.time_s[i - 1]);
  if (steps.empty()) return 1;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return std::max(*middle, 1e-9);
}

// A mean of readings, with a slow part of variance 1.
struct Mean {
  double of_middle = 1;  // covariance with the slow part at the middle of its readings
  double variance = 1;   // of the slow part's mean
};

Mean mean_of(double readings, double span_s, double tau_s) {
  const auto count = static_cast<int>(std::lround(readings));
  if (count < 2) return {};
  const double decay = std::exp(-span_s / (count - 1) / tau_s);
  // The middle at 0: readings half a step or a whole one beside it, and so on.
  double beside = count % 2 == 0 ? std::sqrt(decay) : 1, at_middle = count % 2 == 0 ? 0 : 1;
  for (int k = count % 2; k < count; k += 2) {
    if (count % 2 != 0) beside *= decay;
    at_middle += beside + 1 / beside;
    if (count % 2 == 0) beside *= decay;
  }
  double pairs = count, apart = 1;
  for (int k = 1; k < count; ++k) pairs += 2 * (count - k) * (apart *= decay);
  return {at_middle / count, pairs / count / count};
}

}  // namespace

Timeline Timeline::with_one_spread() const {
  Timeline result = *this;
  if (sd.cols() > 1) result.sd = sd.cwiseAbs2().rowwise().mean().cwiseSqrt();
  return result;
}

Whitener::Whitener(const Timeline& timeline, NoiseShape shape, Eigen::Index output)
    : decay_(timeline.rows()), gain_(timeline.rows()), inverse_sd_(timeline.rows()) {
  if (timeline.sd.size() > 0) weight_ = timeline.sd.col(timeline.spread_of(output)).cwiseInverse();
  const double slow = shape.slow_ratio;
  double variance = slow, before = 1;  // of the slow part, before the row is seen
  for (Eigen::Index i = 0; i < timeline.rows(); ++i) {
    const Mean mean = timeline.readings.size() == 0 || slow == 0
                          ? Mean{}
                          : mean_of(timeline.readings[i], timeline.span_s[i], shape.tau_s);
    if (timeline.restart[static_cast<std::size_t>(i)] != 0) {
      decay_[i] = 0;
      variance = slow;
    } else {
      const double decay = std::exp(-(timeline.time_s[i] - timeline.time_s[i - 1]) / shape.tau_s);
      variance = decay * decay * variance + slow * (1 - decay * decay);
      decay_[i] = decay * mean.of_middle / before;  // of what the row has of the slow part
    }
    before = mean.of_middle;
    // Variance of the row beside the slow part at its middle: negative where it is calmer than
    // that.
    const double own = 1 + slow * (mean.variance - mean.of_middle * mean.of_middle);
    const double seen = mean.of_middle * mean.of_middle * variance, innovation = seen + own;
    gain_[i] = seen / innovation;
    inverse_sd_[i] = 1 / std::sqrt(innovation);
    log_determinant_ += std::log(innovation);
    variance -= gain_[i] * variance;
  }
}

// Each row waits for the one before it: several columns side by side fill the waiting.
template <int columns_at_once>
void Whitener::run(double* first, Eigen::Index stride) const {
  double slow[columns_at_once] = {};
  for (Eigen::Index i = 0; i < decay_.size(); ++i)
    for (int c = 0; c < columns_at_once; ++c) {
      double& value = first[c * stride + i];
      slow[c] *= decay_[i];
      const double innovation = value - slow[c];
      slow[c] += gain_[i] * innovation;
      value = innovation * inverse_sd_[i];
    }
}

void Whitener::apply(Eigen::Ref<Eigen::MatrixXd> columns) const {
  constexpr int kAtOnce = 4;
  if (weight_.size() > 0) columns.array().colwise() *= weight_.array();
  const Eigen::Index stride = columns.outerStride();
  Eigen::Index c = 0;
  for (; c + kAtOnce <= columns.cols(); c += kAtOnce)
    run<kAtOnce>(columns.data() + c * stride, stride);
  for (; c < columns.cols(); ++c) run<1>(columns.data() + c * stride, stride);
}

void Whitener::colour(Eigen::Ref<Eigen::VectorXd> innovations) const {
  double slow = 0;
  for (Eigen::Index i = 0; i < decay_.size(); ++i) {
    slow *= decay_[i];
    const double innovation = innovations[i] / inverse_sd_[i];
    innovations[i] = slow + innovation;
    slow += gain_[i] * innovation;
  }
  if (weight_.size() > 0) innovations.array() /= weight_.array();
}

std::vector<NoiseShape> noise_grid(const Timeline& timeline) {
  constexpr std::array<double, 8> ratios = {0.1, 0.3, 1, 3, 10, 30, 100, 1000};
  constexpr int times = 7;
  std::vector<NoiseShape> grid = {{0, 1}};
  if (timeline.rows() < 3) return grid;
  const double low = 1.5 * typical_step_s(timeline);
  const double length = timeline.time_s.maxCoeff() - timeline.time_s.minCoeff();
  const double high = std::max(length / 4, 2 * low);
  for (const double ratio : ratios)
    for (int k = 0; k < times; ++k)
      grid.push_back({ratio, low * std::pow(high / low, k / double(times - 1))});
  return grid;
}

Eigen::MatrixXd simulated_noise(const Timeline& timeline, const std::vector<NoiseShape>& shapes,
                                const Eigen::MatrixXd& mixing, std::mt19937_64& random) {
  std::normal_distribution<double> normal(0, 1);
  const auto count = static_cast<Eigen::Index>(shapes.size());
  const auto draw = [&] {
    Eigen::VectorXd independent(count);
    for (Eigen::Index o = 0; o < count; ++o) independent[o] = normal(random);
    return Eigen::VectorXd(mixing * independent);
  };
  Eigen::MatrixXd series(timeline.rows(), count);
  if (timeline.readings.size() > 0) {
    for (Eigen::Index i = 0; i < timeline.rows(); ++i) series.row(i) = draw();
    for (Eigen::Index o = 0; o < count; ++o)
      Whitener(timeline, shapes[static_cast<std::size_t>(o)], o).colour(series.col(o));
    return series;
  }
  Eigen::VectorXd slow = Eigen::VectorXd::Zero(count);
  for (Eigen::Index i = 0; i < timeline.rows(); ++i) {
    const bool afresh = timeline.restart[static_cast<std::size_t>(i)] != 0;
    const double dt_s = afresh ? 0 : timeline.time_s[i] - timeline.time_s[i - 1];
    const Eigen::VectorXd pushes = draw(), white = draw();
    for (Eigen::Index o = 0; o < count; ++o) {
      const auto& shape = shapes[static_cast<std::size_t>(o)];
      const double decay = afresh ? 0 : std::exp(-dt_s / shape.tau_s);
      slow[o] = decay * slow[o] + std::sqrt(shape.slow_ratio * (1 - decay * decay)) * pushes[o];
      series(i, o) = slow[o] + white[o];
      if (timeline.sd.size() > 0) series(i, o) *= timeline.sd(i, timeline.spread_of(o));
    }
  }
  return series;
}

}  // namespace driftwise::diagnosis
