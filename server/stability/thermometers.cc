#include "server/stability/thermometers.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "server/stability/drift.h"

namespace driftwise::stability {
namespace {

struct Sum {
  double value = 0, count = 0;
};

// Means of blocks that every thermometer has a value in: [thermometer][block].
struct Blocks {
  std::vector<double> time_s;
  std::vector<std::vector<double>> means;
};

Blocks blocks_of(const std::vector<Thermometer>& thermometers, double block_s) {
  const std::size_t count = thermometers.size();
  std::map<std::int64_t, std::vector<Sum>> sums;
  for (std::size_t k = 0; k < count; ++k)
    for (std::size_t i = 0; i < thermometers[k].series.values.size(); ++i) {
      auto& block =
          sums[static_cast<std::int64_t>(std::floor(thermometers[k].series.time_s[i] / block_s))];
      block.resize(count);
      block[k].value += thermometers[k].series.values[i];
      ++block[k].count;
    }
  Blocks blocks;
  blocks.means.resize(count);
  for (const auto& [number, block] : sums) {
    bool whole = true;
    for (const auto& sum : block) whole = whole && sum.count > 0;
    if (!whole) continue;
    blocks.time_s.push_back((static_cast<double>(number) + 0.5) * block_s);
    for (std::size_t k = 0; k < count; ++k)
      blocks.means[k].push_back(block[k].value / block[k].count);
  }
  return blocks;
}

std::vector<double> mean_of(const Blocks& blocks, const std::vector<bool>& counts) {
  std::vector<double> mean(blocks.time_s.size(), 0);
  const auto n = static_cast<double>(std::ranges::count(counts, true));
  for (std::size_t k = 0; k < counts.size(); ++k)
    for (std::size_t i = 0; counts[k] && i < mean.size(); ++i) mean[i] += blocks.means[k][i] / n;
  return mean;
}

// Offsets of all from the mean of those that count; sizes: of each offset, in its limit.
std::vector<ThermometerOffset> offsets_from(const std::vector<Thermometer>& thermometers,
                                            const Blocks& blocks, const std::vector<bool>& counts,
                                            std::vector<double>& sizes) {
  const auto mean = mean_of(blocks, counts);
  const auto n = static_cast<double>(std::ranges::count(counts, true));
  double certificates = 0;  // variance of the mean by their certificates
  for (std::size_t k = 0; k < counts.size(); ++k)
    if (counts[k])
      certificates += thermometers[k].u_certificate_k * thermometers[k].u_certificate_k / (n * n);
  std::vector<ThermometerOffset> offsets;
  sizes.clear();
  for (std::size_t k = 0; k < counts.size(); ++k) {
    auto difference = blocks.means[k];
    for (std::size_t i = 0; i < difference.size(); ++i) difference[i] -= mean[i];
    const auto drift = drift_of(blocks.time_s, difference).value_or(Drift{});
    const double own = thermometers[k].u_certificate_k * thermometers[k].u_certificate_k;
    const double variance =
        drift.u_mean * drift.u_mean + certificates + own * (counts[k] ? 1 - 2 / n : 1);
    const double limit_k = 2 * std::sqrt(std::max(0.0, variance));
    offsets.push_back({thermometers[k].channel, drift.mean, drift.u_mean, drift.rate_per_h,
                       drift.u_rate_per_h, drift.noise, std::abs(drift.mean) > limit_k});
    sizes.push_back(std::abs(drift.mean) / std::max(limit_k, 1e-12));
  }
  return offsets;
}

}  // namespace

ThermometerComparison compare_thermometers(const std::vector<Thermometer>& thermometers,
                                           double block_s) {
  ThermometerComparison result;
  const auto blocks = blocks_of(thermometers, block_s);
  result.blocks = blocks.time_s.size();
  std::vector<bool> counts(thermometers.size(), true);
  if (!drift_of(blocks.time_s, mean_of(blocks, counts))) return result;
  // One that is out moves the mean, and with it all others: the worst is taken from the mean first.
  // Half of them stay, and two at least: of fewer no one can say which is right.
  for (std::size_t stay = thermometers.size();; --stay) {
    std::vector<double> sizes;
    result.offsets = offsets_from(thermometers, blocks, counts, sizes);
    if (stay <= 2 || 2 * (stay - 1) < thermometers.size()) break;
    std::size_t worst = 0;
    double largest = 1;
    for (std::size_t k = 0; k < sizes.size(); ++k)
      if (counts[k] && sizes[k] > largest) largest = sizes[k], worst = k;
    if (!(largest > 1)) break;
    counts[worst] = false;
  }
  const auto common = drift_of(blocks.time_s, mean_of(blocks, counts));
  result.mean_degc = common->mean;
  result.common_drift_k_per_h = common->rate_per_h;
  return result;
}

}  // namespace driftwise::stability
