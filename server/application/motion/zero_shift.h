#pragma once
// How far should the zero have moved, given the temperatures? Pure.
//
// The run's own returns to zero are regressed on the warming since their datum, each coefficient
// held near 0 by a declared prior (kPriorNmPerKelvin): with no returns the prediction is 0 within
// that many nm per K, with many it is what they say. One formula serves both, and the prediction
// carries its own standard deviation.

#include <span>
#include <string>
#include <vector>

namespace driftwise::application {

struct ZeroObservation {
  std::vector<double> warming_k;  // per temperature of the cell, since the zeroing of its datum
  double closure_nm = 0;          // instrument minus scale, since that zeroing
};

// Per length of the cell, in its order.
using Closures = std::vector<std::vector<ZeroObservation>>;

// closure_nm: one per length; a missing one adds nothing.
void add_closure(Closures& closures, const std::vector<double>& warming_k,
                 std::span<const double> closure_nm);

struct ZeroPrediction {
  double shift_nm = 0, sd_nm = 0;
  std::size_t observations = 0;
};

// The study saw about 200 nm for 1 K of air before compensation; a structure that moves three times
// as much is broken.
constexpr double kPriorNmPerKelvin = 300.0;
constexpr double kClosureNoise_nm =
    10.0;  // of one return: readings (5 nm gate) and the holding of the scale
constexpr double kDatumNoise_nm = 20.0;  // of the zeroing itself, common to all closures of a datum
constexpr double kHomingAllowance_nm = 100.0;  // reference run repeatability, standard deviation

ZeroPrediction predict_zero_shift(std::span<const ZeroObservation> observations,
                                  std::span<const double> warming_k);

struct ZeroComparison {
  ZeroPrediction predicted;
  double found_nm = 0;
  double difference_nm() const { return found_nm - predicted.shift_nm; }
  double limit_nm() const;  // 3 standard deviations of prediction, homing and closure together
  bool surprising() const;
  std::string sentence() const;
};

// Least-squares slope of the zero at rest, nm per minute. times_s and zeros_nm: as many, at least
// two, increasing times.
double drift_nm_per_min(std::span<const double> times_s, std::span<const double> zeros_nm);

}  // namespace driftwise::application
