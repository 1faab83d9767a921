#pragma once
// Data sets with an effect hidden in them, made without any code of the effects, the regression or
// the plant: a linear axis in a room, integrated in one-second steps, with noise of a known shape.
//
// The size of what is hidden is given as chi2 = sum (v - P v)^2 / sigma^2 over the calibration
// rows, what it leaves beyond the baseline q1 ~ x + x^2 + T, whitened by the noise (the statistical
// contract).

#include <cstdint>
#include <string>
#include <vector>

#include "server/core/dataset.h"

namespace driftwise::hidden {

struct Hidden {
  std::string cause;     // of the catalogue; "" for nothing; "uncatalogued"
  double parameter = 0;  // tau_s, width_nm, period_nm, time_s as the cause has it
  double chi2 = 100;
};

struct World {
  int passes = 56;  // of 18 positions
  double step_s = 14.3;
  double noise_nm = 5;         // white, of a point
  double autocorrelation = 0;  // of the slow part from one calibration row to the next
  double slow_share = 0.5;     // of the variance, when autocorrelation is not 0
  int sensors = 6;             // t05 ..
};

struct HiddenData {
  Dataset data;
  std::string baseline;           // formula
  std::vector<double> effect_nm;  // what was hidden, per row
};

HiddenData make(const World& world, const std::vector<Hidden>& hidden, std::uint64_t seed);

// Causes that make() can hide, with a typical parameter.
std::vector<Hidden> hideable();

}  // namespace driftwise::hidden
