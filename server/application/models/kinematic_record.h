#pragma once
// A robot's geometry as a model to be stored: identified on data, or a robot file as it stands.
// Pure.

#include <optional>
#include <string>
#include <vector>

#include "server/application/models/fit_request.h"
#include "server/core/data/dataset.h"
#include "server/core/description/cell_description.h"
#include "server/core/records/records.h"
#include "server/core/result.h"

namespace driftwise::application {

struct KinematicRequest {
  std::string robot;  // text of a robot file; empty: the geometry in the cell file
  // Its formula may be empty: what the geometry reads of it is left to the geometry. Without runs
  // and csv the robot file is the model.
  FitRequest fit;
  bool joint_errors = false;  // of an arm: those that the diagnosis finds are in
  bool has_data() const { return !fit.runs.empty() || !fit.csv.empty(); }
};

struct KinematicFit {
  ModelRecord model;
  std::vector<std::string> findings;  // of the diagnosis, sentences
};

// data: as request.has_data(). Errors: those of parse_robot_file and identification::judge_method;
// failed_precondition NO_KINEMATICS (the cell file has no [kinematics]), OTHER_ROBOT (another kind
// of robot, other motors, motors that the cell has no axis for, or lengths and angles that differ
// from the cell's drawing by more than a robot does), BAD_KINEMATICS (identified numbers that no
// robot file may state, or a model that does not read back); invalid_argument BAD_OPTIONS
// (joint_errors without an arm or without data).
Result<KinematicFit> kinematic_record(const std::optional<Dataset>& data,
                                      const KinematicRequest& request, const CellDescription& cell);

}  // namespace driftwise::application
