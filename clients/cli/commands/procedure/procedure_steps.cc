#include "clients/cli/commands/procedure/procedure_steps.h"

#include <algorithm>

#include "clients/cli/core/text.h"

namespace driftwise::cli {
namespace {

std::string number(std::int64_t value) { return std::to_string(value); }

std::string judged_text(const std::vector<ProcedureFacts::Judged>& judged) {
  std::string text;
  for (const auto& one : judged)
    text += (text.empty() ? "" : ", ") + one.output + " " + fixed(one.a90, 1) + " " + one.unit;
  return text;
}

std::string wanted_text(const std::vector<ProcedureFacts::Wanted>& wanted) {
  std::string text;
  for (const auto& one : wanted)
    text += (text.empty() ? "" : ", ") + fixed(one.a90, 1) + " " + one.unit;
  return text;
}

// The first figure above what is wanted in its unit.
const ProcedureFacts::Judged* beyond(const std::vector<ProcedureFacts::Judged>& judged,
                                     const std::vector<ProcedureFacts::Wanted>& wanted) {
  for (const auto& one : judged)
    for (const auto& limit : wanted)
      if (one.unit == limit.unit && one.a90 > limit.a90) return &one;
  return nullptr;
}

ProcedureStep sources_step(const ProcedureFacts& facts) {
  ProcedureStep step{.number = 0, .name = "sources of inaccuracy", .state = "done"};
  for (const auto& [source, measured] : facts.sources)
    (measured ? step.found : step.missing) +=
        ((measured ? step.found : step.missing).empty() ? "" : ", ") + source;
  if (!step.found.empty()) step.found = "considered: " + step.found;
  if (!step.missing.empty()) {
    step.missing = "not considered: " + step.missing;
    step.command = "driftwise devices";
  }
  if (step.found.empty()) step.state = "open";
  return step;
}

ProcedureStep wanted_step(const ProcedureFacts& facts) {
  if (facts.campaign)
    return {
        .number = 1,
        .name = "wanted accuracy",
        .state = "done",
        .found = "A90 " + wanted_text(facts.wanted) + ", stated by run " + number(*facts.campaign)};
  const std::string run = facts.runs.empty() ? "N" : number(facts.runs.front().id);
  return {.number = 1,
          .name = "wanted accuracy",
          .state = "open",
          .missing = "no run states what accuracy its campaign wants",
          .command = "driftwise run tag " + run + " wanted_a90_nm=100"};
}

ProcedureStep measured_step(const ProcedureFacts& facts) {
  ProcedureStep step{.number = 2, .name = "measurements", .state = "open"};
  std::int64_t points = 0, runs = 0;
  std::vector<std::string> setups;
  for (const auto& run : facts.runs) {
    if (!run.done || run.compensated) continue;
    ++runs;
    points += run.points;
    if (!run.setup.empty() && std::ranges::find(setups, run.setup) == setups.end())
      setups.push_back(run.setup);
  }
  if (runs == 0) {
    step.missing = "no run is done";
    step.command = "driftwise run start PLAN.csv --watch";
    return step;
  }
  step.state = "done";
  step.found = number(points) + " points in " + number(runs) + (runs == 1 ? " run" : " runs");
  if (!setups.empty())
    step.found += ", " + number(static_cast<std::int64_t>(setups.size())) + " set-ups";
  return step;
}

ProcedureStep model_step(const ProcedureFacts& facts) {
  ProcedureStep step{.number = 3, .name = "models", .state = "open"};
  if (!facts.model) {
    step.missing = "no model is fitted";
    step.command = "driftwise model grow --run " +
                   (facts.runs.empty() ? std::string("N") : number(facts.runs.front().id));
    return step;
  }
  step.found = "model " + number(facts.model->id) + ": A90 " + judged_text(facts.model->accuracy);
  if (facts.model->validation_rows == 0) {
    step.missing = "it was judged on no validation rows";
    step.command = "driftwise trajectory generate ... --validation";
  } else if (!facts.model->serving) {
    step.missing = "no model serves";
    step.command = "driftwise model promote " + number(facts.model->id);
  } else {
    step.state = "done";
  }
  return step;
}

ProcedureStep validation_step(const ProcedureFacts& facts) {
  ProcedureStep step{.number = 4, .name = "validation in pose coordinates", .state = "open"};
  if (!facts.verified_run) {
    step.missing = "no compensated run is done";
    step.command = "driftwise run start NEW_POSITIONS.csv --compensate --watch";
    return step;
  }
  step.state = "done";
  step.found = "run " + number(*facts.verified_run) + ": A90 " + judged_text(facts.verified);
  return step;
}

ProcedureStep reached_step(const ProcedureFacts& facts) {
  ProcedureStep step{.number = 5, .name = "wanted accuracy reached", .state = "open"};
  if (facts.wanted.empty() || facts.verified.empty()) {
    step.missing =
        facts.wanted.empty() ? "nothing is wanted (step 1)" : "nothing is validated (step 4)";
    return step;
  }
  const auto* worst = beyond(facts.verified, facts.wanted);
  if (worst == nullptr) {
    step.state = "done";
    step.found = "A90 " + judged_text(facts.verified) + ", wanted " + wanted_text(facts.wanted);
    return step;
  }
  step.state = "not reached";
  step.found = worst->output + " " + fixed(worst->a90, 1) + " " + worst->unit + ", wanted " +
               wanted_text(facts.wanted);
  const bool of_model = facts.model && beyond(facts.model->accuracy, facts.wanted) != nullptr;
  const std::string line = facts.model && !facts.model->largest_line.empty()
                               ? "; largest line of the budget: " + facts.model->largest_line
                               : "";
  if (facts.model && !facts.model->largest_line.empty() && !facts.model->largest_is_measured) {
    step.missing = "back to step 0: other instruments or their places" + line;
    step.command = "driftwise model show " + number(facts.model->id);
  } else if (of_model) {
    step.missing = "back to step 3: the model itself is not good enough" + line;
    step.command = "driftwise model grow --run " +
                   (facts.campaign ? number(*facts.campaign) : std::string("N"));
  } else {
    step.missing =
        "back to step 2: the model was good enough when it was fitted; measure again" + line;
    step.command = "driftwise model check";
  }
  return step;
}

}  // namespace

std::vector<ProcedureStep> procedure_steps(const ProcedureFacts& facts) {
  return {sources_step(facts), wanted_step(facts),     measured_step(facts),
          model_step(facts),   validation_step(facts), reached_step(facts)};
}

}  // namespace driftwise::cli
