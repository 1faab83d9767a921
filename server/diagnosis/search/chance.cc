#include "server/diagnosis/search/chance.h"

#include <algorithm>
#include <cmath>

namespace driftwise::diagnosis {
namespace {

constexpr double kStretchSd = 0.1, kMostStretch = 1.8;

}  // namespace

EvidenceTail::EvidenceTail(std::vector<double> null_maxima) {
  if (null_maxima.empty()) return;
  std::ranges::sort(null_maxima);
  // The lower half says nothing of the tail, and there the law is another one: its values count as
  // "at most the median".
  const std::size_t n = null_maxima.size(), censored = n / 2;
  const double median = null_maxima[censored];
  double highest = -INFINITY;
  for (double stretch = 1; stretch <= kMostStretch; stretch += 0.05) {
    const double scale = 2 * stretch;
    // m above the median u: e^(location / scale) = m / (k e^(-u / scale) + sum e^(-x / scale))
    double sum = static_cast<double>(censored);
    for (std::size_t i = censored; i < n; ++i) sum += std::exp(-(null_maxima[i] - median) / scale);
    const double m = static_cast<double>(n - censored);
    const double location = median + scale * std::log(m / sum);
    double likelihood = -std::pow((stretch - 1) / kStretchSd, 2) / 2 -
                        static_cast<double>(censored) * std::exp(-(median - location) / scale);
    for (std::size_t i = censored; i < n; ++i) {
      const double z = (null_maxima[i] - location) / scale;
      likelihood += -z - std::exp(-z) - std::log(scale);
    }
    if (likelihood <= highest) continue;
    highest = likelihood;
    location_ = location;
    scale_ = scale;
  }
}

double EvidenceTail::p(double evidence) const {
  return -std::expm1(-std::exp(-(evidence - location_) / scale_));
}

}  // namespace driftwise::diagnosis
