#pragma once
// From a simulated campaign to targets judged by the truth, through what a cell runs: dataset, fit,
// the model's JSON, snapshot, compute_target. Nothing here knows a plant.

#include <string>
#include <vector>

#include "server/calibration/model/model.h"
#include "server/compensation/target.h"
#include "server/core/data/dataset.h"
#include "server/core/data/reading.h"
#include "server/core/description/cell_description.h"

namespace driftwise::statistics {

// A moment at which the end-effector was at a pose that the plant knows, with what the cell saw of
// it: asked for that pose, the model should have answered what the scales read.
struct JudgedTarget {
  CellTime at;
  compensation::TargetRequest true_pose;  // since the zero; force as declared
  std::vector<ChannelValue> conditions;   // temperatures at that moment, as measured
  std::vector<double> q_mm;               // read back from the scales
};

struct SimulatedCase {
  Dataset dataset;  // as the cell would export it
  std::vector<JudgedTarget> targets;
  CellDescription cell;
  std::string formula;
  CellTime zero_at{};  // of the lengths, from which the poses count
};

struct Outcome {  // of one target and one motor coordinate
  std::size_t target = 0, output = 0;
  double error_nm = 0, u_nm = 0;
  double since_zero_h = 0;
  bool inside_domain = true;
  compensation::Budget budget;
};

struct Served {
  calibration::Model model;
  std::vector<Outcome> outcomes;
};

// Throws std::runtime_error with the sentence of whatever refused: here every step must work.
Served serve_and_judge(const SimulatedCase& simulated);

}  // namespace driftwise::statistics
