#pragma once
// The Micro-Nano measured in two datums while the room warms or cools, and what a model fitted to
// both then serves in a third: judged by the plant's truth.

#include <array>
#include <cstdint>
#include <vector>

#include "server/calibration/model/model.h"
#include "server/core/data/dataset.h"
#include "server/core/description/cell_description.h"
#include "server/diagnosis/check/check_errors.h"
#include "tests/support/micro_nano_campaign.h"

namespace driftwise::statistics {

struct TwoDatumsOptions {
  double room_k = 5;   // the room's balance above where the campaign begins
  double pause_h = 4;  // before the second and before the third datum
  bool coarse = true;  // micro_nano_campaign.h
};

// A datum's zero: what its record would hold, and where it truly lies.
struct DatumZero {
  std::vector<ChannelValue> values;      // q1_mm .. q3_mm, t01_degC .. t10_degC, force_N
  std::array<double, 3> true_pose_mm{};  // in the first datum's frame
};

struct TwoDatums {
  CellDescription cell;
  Dataset data;  // both datums, the second under other forces; column datum 1, 2
  std::array<DatumZero, 3> zeros;
  // Poses anywhere in the workspace, in the third datum. Never fitted.
  std::vector<testing_support::MicroNanoRow> judged;
};

TwoDatums two_datums_case(std::uint64_t seed, const TwoDatumsOptions& options = {});

extern const char* const kTwoDatumsFormula;  // coverage's

// Rows of one datum alone; poses moved to where their datum's zero truly lies.
Dataset only_datum(const Dataset& data, std::int64_t datum);
Dataset at_true_zeros(const TwoDatums& made);

// The rows of the third datum as a run to check a model with: lengths as measured there.
diagnosis::RunToCheck third_datum_run(const TwoDatums& made);

// What the model serves in the third datum, minus what the scales read there: 1.645 x root mean
// square, nm, per motor. Throws std::runtime_error with the sentence of whatever refused.
std::array<double, 3> u90_in_third_datum(const calibration::Model& model, const TwoDatums& made);

}  // namespace driftwise::statistics
