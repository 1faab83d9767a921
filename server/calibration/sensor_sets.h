#pragma once
// Which thermometers suffice? Fits the formula with every set of the thermometers that it names and
// says, for each number of them, which set is best and what each fewer costs.

#include <optional>
#include <string>
#include <vector>

#include "server/calibration/fit.h"

namespace driftwise::calibration {

struct SensorFigure {  // of one output, its column unit; figures of server/core/data/accuracy.h
  std::string output;
  // Held out by blocks of time, selection repeated inside.
  double u90_blocks = 0, mean_blocks = 0, a90_blocks = 0;
  std::optional<double> u90_validation, mean_validation, a90_validation;  // rows marked validation
};

struct SensorSet {
  std::vector<std::string> sensors;  // "t05"; the terms of all others were left out
  std::vector<SensorFigure> outputs;
  double a90_blocks_rms = 0;  // root mean square over the outputs: what sets are ranked by
  double u90_blocks_rms = 0;
  std::optional<double> a90_validation_rms, u90_validation_rms;
};

struct SensorStudy {
  std::vector<SensorSet> best;  // the best set of n, n - 1, ... 0 sensors
  // Index: the fewest that are within `tolerance` of the best, by blocks of time and, where there
  // are validation rows, on those too: these rank nothing, they can only say no. Blocks of time lie
  // inside the temperatures of the calibration; rows measured later and warmer may not.
  std::size_t recommended = 0;
  std::size_t sets_tried = 0;
  double tolerance = 0;
};

constexpr std::size_t kMostSensors = 14;  // 16 384 sets

// Every set is tried: no greedy path that misses two sensors which only help together. base: as for
// fit(), blocks at least 2; its executor shares out the sets. tolerance: of the recommendation, as
// a share. Errors: invalid_argument NO_SENSORS (no thermometer among the candidates),
// TOO_MANY_SENSORS, NO_BLOCKS, UNITS_DISAGREE (outputs in several units); those of fit() with all
// sensors. A set that cannot be fitted is passed over.
Result<SensorStudy> study_sensors(const Dataset& dataset, const FitOptions& base,
                                  double tolerance = 0.1);

}  // namespace driftwise::calibration
