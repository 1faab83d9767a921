#pragma once
// The snapshots of all models of a plan, taken at one instant, and how they are put together. Built
// by JointBuilder, published on a JointBoard, immutable afterwards: any thread may read it.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/compensation/snapshot.h"
#include "server/compensation/snapshot_board.h"
#include "server/core/ids.h"
#include "server/plans/blend.h"
#include "server/plans/serving_plan.h"

namespace driftwise::plans {

struct JointSnapshot {
  struct Robot {
    std::string id;
    compensation::Snapshot fine;  // the one model, or the fine one of a blend
    std::optional<compensation::Snapshot> coarse;
    bool same_terms = false;  // of fine and coarse: have_same_terms
    Band band;
    std::uint32_t needed = 0;  // bit per Variable: inputs of its motor coordinates
    // Inputs that a request states: needed, and what a step from this robot reads besides.
    std::uint32_t stated = 0;
    std::vector<std::string> motors;  // "ma.q1", by output
  };
  struct Step {
    std::size_t from = 0, to = 0;  // robots
    compensation::Snapshot predicts;
    std::vector<compensation::Variable> output;  // of predicts.outputs, in their order
    std::uint32_t added = 0;                     // bit per output
    // "mn.x" by output: with the robot that it is added to, else with the one that it is seen of.
    std::vector<std::string> terms;
  };

  PlanId plan;
  CellTime built_at, valid_until;
  std::vector<Robot> robots;  // none: no plan serves
  std::vector<Step> steps;
  std::size_t passes = 1;  // through the steps; more where some wait for one another in a circle
  std::optional<std::size_t> z_taken_by;
  double z_rest_mm = 0;
  bool refuse_stale = false, refuse_outside_domain = false, refuse_outside_limits = true;
  // Why the plan that should serve does not; none: nothing is promoted.
  std::optional<Error> unserved;

  std::optional<std::size_t> robot_index(std::string_view id) const;
};

using JointBoard = compensation::Board<JointSnapshot>;

}  // namespace driftwise::plans
