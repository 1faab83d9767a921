#pragma once
// Turns a plan, its models and the observed stream of readings into joint snapshots: one
// SnapshotBuilder per use of a model. One thread.

#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/calibration/model/model.h"
#include "server/compensation/snapshot_builder.h"
#include "server/core/description/cell_description.h"
#include "server/plans/joint_snapshot.h"
#include "server/plans/serving_plan.h"

namespace driftwise::plans {

using ModelsById = std::map<ModelId, calibration::Model>;

class JointBuilder {
 public:
  // models: every one that the plan names. Errors: those of SnapshotBuilder::create and
  // part_of_robot, naming the model; failed_precondition NOT_A_MOTOR_MODEL (also a geometry),
  // OTHER_OUTPUTS (two models of a blend give other motor coordinates), NO_OUTPUT (a step adds what
  // its model does not give), MODEL_TOO_LARGE.
  static Result<JointBuilder> create(ServingPlan plan, PlanId id, const ModelsById& models,
                                     const CellDescription& cell);

  void observe(const Reading& reading) { observe(reading.values, reading.middle()); }
  void observe(std::span<const ChannelValue> values, CellTime at);

  // Full names of the channels that observe() does not pass over, each once.
  std::vector<std::string> observed_channels() const;
  Nanoseconds memory() const;  // the longest of the models'

  // As SnapshotBuilder::anchor, of every part. own: this model was fitted in the present datum.
  // Answers with what did not fit, a sentence each.
  std::vector<std::string> anchor(std::span<const ChannelValue> values,
                                  const std::function<bool(ModelId)>& own);

  // finish: what the caller adds to each part's snapshot, by its model.
  JointSnapshot build(
      CellTime now, const std::function<void(ModelId, compensation::Snapshot&)>& finish = {}) const;

  // Full names of slow channels that some model reads.
  const std::vector<std::string>& slow_channels() const { return slow_channels_; }
  const ServingPlan& plan() const { return plan_; }

 private:
  struct Part {
    ModelId model;
    std::string robot;
    compensation::SnapshotBuilder builder;
  };
  JointBuilder() = default;
  Result<std::size_t> add_part(ModelId model, const std::string& robot, compensation::Gives gives,
                               const ModelsById& models, const CellDescription& cell);

  ServingPlan plan_;
  PlanId id_;
  ServingRules rules_;
  std::vector<Part> parts_;
  struct RobotParts {
    std::size_t fine = 0;
    std::optional<std::size_t> coarse;
  };
  std::vector<RobotParts> robots_;
  std::vector<std::size_t> steps_;  // parts, by step
  std::vector<std::string> slow_channels_;
};

}  // namespace driftwise::plans
