#include "server/stability/thermometers.h"

#include <cmath>
#include <map>

#include "server/stability/drift.h"

namespace driftwise::stability {
namespace {

struct Sum {
  double value = 0, count = 0;
};

}  // namespace

ThermometerComparison compare_thermometers(const std::vector<Thermometer>& thermometers,
                                           double block_s) {
  ThermometerComparison result;
  const std::size_t count = thermometers.size();
  // block -> what each of them has in it
  std::map<std::int64_t, std::vector<Sum>> blocks;
  for (std::size_t k = 0; k < count; ++k)
    for (std::size_t i = 0; i < thermometers[k].series.values.size(); ++i) {
      auto& block =
          blocks[static_cast<std::int64_t>(std::floor(thermometers[k].series.time_s[i] / block_s))];
      block.resize(count);
      block[k].value += thermometers[k].series.values[i];
      ++block[k].count;
    }
  std::vector<double> time_s, mean;
  std::vector<std::vector<double>> difference(count);
  for (const auto& [number, sums] : blocks) {
    double all = 0;
    bool whole = true;
    for (const auto& sum : sums) {
      whole = whole && sum.count > 0;
      if (whole) all += sum.value / sum.count / static_cast<double>(count);
    }
    if (!whole) continue;
    time_s.push_back((static_cast<double>(number) + 0.5) * block_s);
    mean.push_back(all);
    for (std::size_t k = 0; k < count; ++k)
      difference[k].push_back(sums[k].value / sums[k].count - all);
  }
  result.blocks = time_s.size();
  const auto common = drift_of(time_s, mean);
  if (!common) return result;
  result.mean_degc = common->mean;
  result.common_drift_k_per_h = common->rate_per_h;
  double certificates = 0;  // variance of the mean of all by their certificates
  const double n = static_cast<double>(count);
  for (const auto& one : thermometers) certificates += one.u_certificate_k * one.u_certificate_k;
  for (std::size_t k = 0; k < count; ++k) {
    const auto drift = drift_of(time_s, difference[k]);
    if (!drift) continue;
    const double u_own = thermometers[k].u_certificate_k;
    const double u2 =
        drift->u_mean * drift->u_mean + u_own * u_own * (1 - 2 / n) + certificates / (n * n);
    result.offsets.push_back({thermometers[k].channel, drift->mean, drift->u_mean,
                              drift->rate_per_h, drift->u_rate_per_h, drift->noise,
                              std::abs(drift->mean) > 2 * std::sqrt(std::max(0.0, u2))});
  }
  return result;
}

}  // namespace driftwise::stability
