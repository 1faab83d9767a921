#pragma once
// Thermometers at one temperature: offsets of each from the mean of those that agree.

#include <string>
#include <vector>

#include "server/stability/samples.h"

namespace driftwise::stability {

struct Thermometer {
  std::string channel;
  double u_certificate_k = 0;
  Samples series;
};

struct ThermometerOffset {
  std::string channel;
  double offset_k = 0, u_offset_k = 0;
  double drift_k_per_h = 0, u_drift_k_per_h = 0;  // of the difference from the mean
  double noise_k = 0;
  // The offset is beyond twice the standard uncertainty of noise and certificates together.
  bool out = false;
};

struct ThermometerComparison {
  double mean_degc = 0, common_drift_k_per_h = 0;
  std::size_t blocks = 0;  // that all of them have a value in; fewer than 8: no offsets
  std::vector<ThermometerOffset> offsets;
};

// Over the series' common time, in blocks of block_s. The mean is that of the thermometers that are
// in: the one that is out farthest is taken from it first, as long as half of
// them stay, and two at least.
ThermometerComparison compare_thermometers(const std::vector<Thermometer>& thermometers,
                                           double block_s);

}  // namespace driftwise::stability
