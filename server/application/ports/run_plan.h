#pragma once
// How a run is to be made, as its record keeps it (rules_json): after a restart it goes on by the
// same rules.

#include <optional>
#include <string>

#include "server/core/description/cell_description.h"
#include "server/core/ids.h"
#include "server/core/records/records.h"
#include "server/core/result.h"

namespace driftwise::application {

struct RunPlan {
  RunRules rules;
  bool compensate = false;
  std::optional<ModelId> compensate_with;  // none: the model that serves when a row is moved to
  std::optional<ModelId> served_at_start;  // then the one that did so when the run was created
  std::string setup = {};                  // [[setup]] of the cell file; empty: all instruments
  // In a cell with several robots, of a compensated run: the serving plan when it was created. A
  // row is moved to by the one that serves then.
  std::optional<PlanId> plan_at_start = {};
};

// What a run was compensated with, as far as its record says.
struct Compensation {
  bool compensated = false;
  std::optional<ModelId> model;
  std::optional<PlanId> plan;  // several robots
};
Compensation compensation_of(const RunRecord& run);
std::string compensation_text(const Compensation& of);  // "none", "model 3", "plan 2";

std::string setup_of(const RunRecord& run);  // empty: all instruments

// Of an entry that waits: without rules the cell's rules of its start count.
std::string write_waiting_plan(const std::optional<RunRules>& rules, const std::string& setup);
bool states_rules(const std::string& json);

std::string write_run_plan(const RunPlan& plan);
// Errors: data_loss BAD_RUN_PLAN. Keys that are absent keep their default, so that old records stay
// readable.
Result<RunPlan> read_run_plan(const std::string& json);

// Errors: invalid_argument NO_SUCH_SETUP, naming those of the cell. Empty is good.
Result<void> check_setup(const CellDescription& cell, const std::string& setup);

// Errors: invalid_argument BAD_RULES, naming the rule, its value and the range.
Result<void> check_rules(const RunRules& rules);

}  // namespace driftwise::application
