#include "tests/statistics/coverage_count.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/special_functions/beta.hpp>
#include <cmath>
#include <random>

namespace driftwise::statistics {

Interval clopper_pearson(double hits, double tries, double confidence) {
  const double tail = (1 - confidence) / 2;
  Interval out;
  if (hits > 0) out.low = boost::math::ibeta_inv(hits, tries - hits + 1, tail);
  if (hits < tries) out.high = boost::math::ibeta_inv(hits + 1, tries - hits, 1 - tail);
  return out;
}

void CoverageCount::add_campaign(std::int64_t hits, std::int64_t targets) {
  if (targets == 0) return;
  campaigns_.push_back({static_cast<double>(hits), static_cast<double>(targets)});
  hits_ += hits;
  targets_ += targets;
}

double CoverageCount::rate() const {
  return targets_ == 0 ? 0 : static_cast<double>(hits_) / static_cast<double>(targets_);
}

double CoverageCount::effective_targets() const {
  const auto clusters = static_cast<double>(campaigns_.size());
  const auto n = static_cast<double>(targets_);
  const double p = rate();
  if (clusters < 2 || p <= 0 || p >= 1) return n;
  double squares = 0;  // variance of a ratio of totals over clusters
  for (const auto& campaign : campaigns_)
    squares += std::pow(campaign.hits - p * campaign.targets, 2);
  const double variance = clusters / (clusters - 1) * squares / (n * n);
  if (!(variance > 0)) return n;
  return std::min(n, p * (1 - p) / variance);
}

Interval CoverageCount::resampled(int collections) const {
  if (campaigns_.size() < 2) return {};
  std::mt19937_64 random(1);
  std::uniform_int_distribution<std::size_t> any(0, campaigns_.size() - 1);
  std::vector<double> rates;
  for (int i = 0; i < collections; ++i) {
    double hits = 0, targets = 0;
    for (std::size_t k = 0; k < campaigns_.size(); ++k) {
      const auto& campaign = campaigns_[any(random)];
      hits += campaign.hits, targets += campaign.targets;
    }
    rates.push_back(hits / targets);
  }
  std::ranges::sort(rates);
  const auto at = [&](double share) {
    return rates[static_cast<std::size_t>(share * static_cast<double>(rates.size() - 1))];
  };
  return {at(0.025), at(0.975)};
}

Interval CoverageCount::clustered() const {
  double effective = effective_targets();
  const auto clusters = static_cast<double>(campaigns_.size());
  if (clusters >= 2 && targets_ > 2) {
    const auto t = [](double dof) {
      return boost::math::quantile(boost::math::students_t(dof), 0.975);
    };
    effective *= std::pow(t(static_cast<double>(targets_ - 1)) / t(clusters - 1), 2);
  }
  return clopper_pearson(rate() * effective, effective);
}

}  // namespace driftwise::statistics
