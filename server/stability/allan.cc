#include "server/stability/allan.h"

#include <algorithm>
#include <cmath>

#include "server/core/text/quantity_text.h"

namespace driftwise::stability {
namespace {

// Slope of log deviation over log tau between two points, of which not both are 0.
double slope(const AllanPoint& a, const AllanPoint& b) {
  if (!(b.deviation > 0)) return -HUGE_VAL;
  if (!(a.deviation > 0)) return HUGE_VAL;
  return std::log(b.deviation / a.deviation) / std::log(b.tau_s / a.tau_s);
}

const char* name_of_slope(double slope) {
  if (slope < -0.75) return "noise that averages faster than white noise";
  if (slope < -0.25) return "white noise";
  if (slope < 0.25) return "flicker noise";
  if (slope < 0.75) return "a random walk";
  return "a drift";
}

const char* name_of_noise(const AllanPoint& a, const AllanPoint& b) {
  if (!(a.deviation > 0) && !(b.deviation > 0)) return "no change";
  return name_of_slope(slope(a, b));
}

}  // namespace

std::vector<AllanPoint> allan_deviation(std::span<const double> values, double interval_s,
                                        std::span<const std::size_t> factors) {
  // Sums from the mean on: what is added stays small beside the differences.
  const std::size_t count = values.size();
  double mean = 0;
  for (const double value : values) mean += value / static_cast<double>(count);
  std::vector<double> sums(count + 1, 0);
  for (std::size_t i = 0; i < count; ++i) sums[i + 1] = sums[i] + (values[i] - mean);
  std::vector<AllanPoint> points;
  for (const std::size_t m : factors) {
    if (m == 0 || 2 * m > count) continue;
    const std::size_t terms = count - 2 * m + 1;
    double squares = 0;
    for (std::size_t j = 0; j < terms; ++j) {
      const double difference =
          (sums[j + 2 * m] - 2 * sums[j + m] + sums[j]) / static_cast<double>(m);
      squares += difference * difference;
    }
    AllanPoint point;
    point.factor = m;
    point.tau_s = static_cast<double>(m) * interval_s;
    point.terms = terms;
    point.deviation = std::sqrt(squares / (2 * static_cast<double>(terms)));
    const double independent =
        std::max(1.0, static_cast<double>(count) / static_cast<double>(m) - 1);
    const double relative = 1 / std::sqrt(2 * independent);
    point.low = point.deviation * std::max(0.0, 1 - relative);
    point.high = point.deviation * (1 + relative);
    points.push_back(point);
  }
  return points;
}

std::vector<std::size_t> octaves(std::size_t values) {
  std::vector<std::size_t> factors;
  for (std::size_t m = 1; m <= std::max<std::size_t>(1, values / 4); m *= 2) factors.push_back(m);
  return factors;
}

std::string noise_sentence(std::span<const AllanPoint> points) {
  if (points.size() < 3) return "too few averaging times to name the noise";
  if (std::ranges::none_of(points, [](const auto& point) { return point.deviation > 0; }))
    return "no noise: every value is the same, which a display coarser than the noise shows, or an "
           "instrument that repeats its last reading";
  const std::size_t last = points.size() - 1;
  const std::string first_kind = name_of_noise(points[0], points[2]);
  const std::string last_kind = name_of_noise(points[last - 2], points[last]);
  const auto best =
      std::min_element(points.begin(), points.end(),
                       [](const auto& a, const auto& b) { return a.deviation < b.deviation; });
  std::string text = first_kind + " at the shortest times";
  if (last_kind != first_kind) text += ", " + last_kind + " at the longest";
  text += best == points.end() - 1
              ? "; averaging still helps at " + digits_text(best->tau_s) + " s"
              : "; averaging beyond " + digits_text(best->tau_s) + " s does not help";
  return text;
}

}  // namespace driftwise::stability
