#pragma once
// What stands against a plan's promotion. Pure.

#include <map>
#include <string>
#include <vector>

#include "server/core/description/cell_description.h"
#include "server/core/result.h"
#include "server/plans/band_check.h"
#include "server/plans/joint_builder.h"
#include "server/plans/serving_plan.h"

namespace driftwise::plans {

struct PlanFinding {
  bool refuses = true;  // false: a question that a person answers at promotion
  std::string reason, message;
};

struct PlanCheck {
  std::vector<PlanFinding> findings;
  std::vector<BandReport> bands;  // of every blend that could be looked at

  // The first finding that refuses, as an error; its message holds those that follow.
  Result<void> refusal() const;
  std::vector<std::string> questions() const;
};

// tools: by model, the tools that its runs were measured with, as far as they are known.
PlanCheck check_plan(const ServingPlan& plan, const ModelsById& models,
                     const std::map<ModelId, std::vector<std::string>>& tools,
                     const CellDescription& cell);

}  // namespace driftwise::plans
