#pragma once
// A robot's discrepancy and what each of its parameters would do to it, as one linear problem:
// raw, for figures in nm, and whitened, for evidence.
//
// Rows of every matrix here: all learning rows of the first output, then of the second, ...

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "server/diagnosis/answer/diagnosis.h"
#include "server/diagnosis/rows/problem.h"
#include "server/identification/identify.h"

namespace driftwise::diagnosis {

// Turns of an arm's joints that are not among its parameters.
struct JointTurns {
  Eigen::MatrixXd rad;             // every row of the dataset x shapes
  std::vector<std::size_t> joint;  // of each shape, from 0
};

struct WhitenedGeometry {
  // White: parameters, then further linear terms of each output, then joint turns per unit.
  Eigen::MatrixXd columns;
  Eigen::VectorXd y;               // white: measured minus the nominal robot
  Eigen::MatrixXd raw, raw_judge;  // the same columns in summary units; on the judging rows
  Eigen::VectorXd y_raw_judge;
};

// The same without whitening: columns and y are the raw ones.
WhitenedGeometry plain_geometry(const Dataset& marked, const Problem& problem,
                                const identification::Identification& identified,
                                const JointTurns& turns = {});

// Derivatives at `identified`; the discrepancy is that of the parameters' nominal values, where the
// robot was placed (identified's placement). shapes: that the noise of each output chooses from.
// Nothing: tick said false.
std::optional<WhitenedGeometry> whitened_geometry(const Dataset& marked, const Problem& problem,
                                                  const identification::Identification& identified,
                                                  const std::vector<NoiseShape>& shapes,
                                                  const std::function<bool()>& tick);

// Effect of one number of a robot on every output, as the root of its mean square over the rows
// that learn. beyond: learning rows, what nothing else explains. before, after: what is left on the
// judging rows without it and with it; no figures of fewer than four rows.
std::vector<FindingOutput> outputs_moved(const Problem& problem, const Eigen::VectorXd& beyond,
                                         const Eigen::VectorXd& before,
                                         const Eigen::VectorXd& after);

}  // namespace driftwise::diagnosis
