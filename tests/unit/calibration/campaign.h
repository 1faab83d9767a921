#pragma once
// A small linear-axis campaign: a visit pattern, drifting temperatures, known coefficients, noise
// of a few nm.

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "server/core/data/dataset.h"

namespace driftwise::calibration {

struct Campaign {
  int rows = 400;
  int thermometers = 4;
  double noise_mm = 3e-6;
  unsigned seed = 1;
  int datums = 1;
};

// q1 = 1.0001 x + 2e-5 x^2 + 4e-4 (t01 - 21) - 2e-4 (t02 - 21) + noise; every third row validation.
inline Dataset make_campaign(const Campaign& campaign) {
  Dataset data;
  std::mt19937 random(campaign.seed);
  std::normal_distribution<double> normal;
  data.rows = static_cast<std::size_t>(campaign.rows);
  data.columns.push_back({{"q1", "mm"}, {}});
  data.columns.push_back({{"x", "mm"}, {}});
  for (int k = 1; k <= campaign.thermometers; ++k)
    data.columns.push_back({{"t0" + std::to_string(k), "degC"}, {}});
  std::vector<double> wander(static_cast<std::size_t>(campaign.thermometers));
  for (int i = 0; i < campaign.rows; ++i) {
    const double time_s = 14.3 * i;
    const double x = -4 + 0.5 * (i % 17) + 1e-5 * normal(random);
    double q = 1.0001 * x + 2e-5 * x * x;
    data.time_s.push_back(time_s);
    data.set.push_back(i % 3 == 2 ? PointSet::validation : PointSet::calibration);
    if (campaign.datums > 1) {
      const int datum = i * campaign.datums / campaign.rows;
      data.datum.push_back(100 + datum);
      q += 5e-4 * datum;
    }
    for (int k = 0; k < campaign.thermometers; ++k) {
      auto& w = wander[static_cast<std::size_t>(k)];
      w = 0.98 * w + 0.01 * normal(random);
      const double t = 21 + 0.5 * std::sin(time_s / (2000.0 + 700 * k)) + w;
      data.columns[static_cast<std::size_t>(2 + k)].values.push_back(t);
      if (k == 0) q += 4e-4 * (t - 21);
      if (k == 1) q -= 2e-4 * (t - 21);
    }
    data.columns[0].values.push_back(q + campaign.noise_mm * normal(random));
    data.columns[1].values.push_back(x);
  }
  return data;
}

}  // namespace driftwise::calibration
