#include "server/application/procedure/procedure_steps.h"

#include <fmt/format.h>

#include <algorithm>

namespace driftwise::application {
namespace {

using State = ProcedureStep::State;
using Judged = std::vector<ProcedureFacts::Judged>;

std::string judged_text(const Judged& judged) {
  std::string text;
  for (const auto& one : judged)
    text += fmt::format("{}{} {:.1f} {}", text.empty() ? "" : ", ", one.output, one.a90, one.unit);
  return text;
}

std::vector<ProcedureFigure> figures_of(const Judged& judged, const ProcedureFacts& facts) {
  std::vector<ProcedureFigure> figures;
  for (const auto& one : judged) {
    const auto* wanted = wanted_of(facts.wanted, one.output, one.unit);
    figures.push_back(
        {one.output, one.unit, one.a90, wanted ? std::optional(wanted->a90) : std::nullopt});
  }
  return figures;
}

bool is_missed(const ProcedureFigure& figure) {
  return figure.a90 && figure.wanted && *figure.a90 > *figure.wanted;
}

// The figure that is the most times above what is wanted of it; nullptr: none is.
const ProcedureFigure* worst_missed(const std::vector<ProcedureFigure>& figures) {
  const ProcedureFigure* worst = nullptr;
  for (const auto& one : figures)
    if (is_missed(one) && (!worst || *one.a90 / *one.wanted > *worst->a90 / *worst->wanted))
      worst = &one;
  return worst;
}

ProcedureStep sources_step(const ProcedureFacts& facts) {
  ProcedureStep step{.number = 0, .name = "sources of inaccuracy", .state = State::done};
  step.sources = facts.sources;
  for (const auto& source : facts.sources) {
    auto& text = source.measured_by.empty() ? step.missing : step.found;
    text += (text.empty() ? "" : ", ") + source.name;
  }
  if (!step.found.empty()) step.found = "considered: " + step.found;
  if (!step.missing.empty()) {
    step.missing = "not considered: " + step.missing;
    step.command = "driftwise devices";
  }
  if (step.found.empty()) step.state = State::open;
  return step;
}

ProcedureStep wanted_step(const ProcedureFacts& facts) {
  ProcedureStep step{.number = 1, .name = "wanted accuracy"};
  for (const auto& one : facts.wanted)
    step.figures.push_back({one.coordinate, one.unit, std::nullopt, one.a90});
  for (const auto& sentence : facts.unreadable)
    step.missing += (step.missing.empty() ? "" : "; ") + sentence;
  if (facts.campaign) {
    step.state = State::done;
    step.found =
        fmt::format("A90: {}, stated by run {}", wanted_text(facts.wanted), *facts.campaign);
    return step;
  }
  const auto run = facts.runs.empty() ? "N" : std::to_string(facts.runs.front().id);
  if (step.missing.empty()) step.missing = "no run states what accuracy its campaign wants";
  step.command = fmt::format("driftwise run tag {} wanted_a90.x_nm=100", run);
  return step;
}

ProcedureStep measured_step(const ProcedureFacts& facts) {
  ProcedureStep step{.number = 2, .name = "measurements"};
  std::int64_t points = 0, runs = 0;
  std::vector<std::string> setups;
  for (const auto& run : facts.runs) {
    if (!run.done || run.compensated || run.joined) continue;
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
  step.state = State::done;
  step.found = fmt::format("{} points in {} {}", points, runs, runs == 1 ? "run" : "runs");
  if (!setups.empty())
    step.found += fmt::format(", {} set-up{}", setups.size(), setups.size() == 1 ? "" : "s");
  return step;
}

ProcedureStep model_step(const ProcedureFacts& facts) {
  ProcedureStep step{.number = 3, .name = "models"};
  if (!facts.model) {
    step.missing = "no model is fitted";
    step.command = "driftwise model grow --run " +
                   (facts.runs.empty() ? std::string("N") : std::to_string(facts.runs.front().id));
    return step;
  }
  step.found = fmt::format("model {}: A90 {}", facts.model->id, judged_text(facts.model->accuracy));
  step.figures = figures_of(facts.model->accuracy, facts);
  if (!facts.model->doubt.empty()) {
    step.missing = fmt::format("recalibrate now: the robot no longer does what model {} says: {}",
                               facts.model->id, facts.model->doubt);
    step.command = "driftwise model check";
  } else if (facts.model->validation_rows == 0) {
    step.missing = "it was judged on no validation rows";
    step.command = "driftwise trajectory generate ... --validation";
  } else if (!facts.model->serving) {
    step.missing = "no model serves";
    step.command = fmt::format("driftwise model promote {}", facts.model->id);
  } else {
    step.state = State::done;
  }
  return step;
}

ProcedureStep validation_step(const ProcedureFacts& facts) {
  ProcedureStep step{.number = 4, .name = "validation in pose coordinates"};
  if (!facts.verified_run) {
    step.missing = "no compensated run is done";
    step.command = "driftwise run start NEW_POSITIONS.csv --compensate --watch";
    return step;
  }
  if (!facts.not_verified.empty()) {
    step.missing =
        fmt::format("run {} cannot be judged: {}", *facts.verified_run, facts.not_verified);
    step.command = "driftwise run start NEW_POSITIONS.csv --compensate --watch";
    return step;
  }
  step.state = State::done;
  step.figures = figures_of(facts.verified, facts);
  step.found = fmt::format("run {}: A90 {}", *facts.verified_run, judged_text(facts.verified));
  return step;
}

// Whether the model's budget can be the reason of what was measured: an rms error up to twice what
// it states. Beyond it no instrument of the budget is to blame.
bool is_within_budget(const ProcedureFacts& facts, double combined_u_nm) {
  constexpr double kRmsOfA90 = 1 / 1.645, kMost = 2;
  return std::ranges::all_of(facts.verified, [&](const auto& one) {
    return one.unit != "nm" || one.a90 * kRmsOfA90 <= kMost * combined_u_nm;
  });
}

// The step to return to, and why.
void go_back(const ProcedureFacts& facts, ProcedureStep& step) {
  const auto& model = facts.model;
  std::string line;
  if (model && !model->largest_line.empty()) {
    step.largest_line = model->largest_line;
    step.largest_u_nm = model->largest_u_nm;
    line = fmt::format("; largest line of the budget: {} {:.1f} nm", model->largest_line,
                       model->largest_u_nm);
  }
  if (model && !model->largest_line.empty() && !model->largest_is_measured &&
      is_within_budget(facts, model->combined_u_nm)) {
    step.back_to = 0;
    step.missing = "back to step 0: other instruments or their places" + line;
    step.command = fmt::format("driftwise design --model {} --list", model->id);
  } else if (model && worst_missed(figures_of(model->accuracy, facts))) {
    step.back_to = 3;
    step.missing = "back to step 3: the model itself is not good enough" + line;
    step.command = "driftwise model grow --run " +
                   (facts.campaign ? std::to_string(*facts.campaign) : std::string("N"));
  } else {
    step.back_to = 2;
    step.missing =
        "back to step 2: the model was good enough when it was fitted; measure again" + line;
    step.command = "driftwise model check";
  }
}

ProcedureStep reached_step(const ProcedureFacts& facts) {
  ProcedureStep step{.number = 5, .name = "wanted accuracy reached"};
  if (facts.wanted.empty() || facts.verified.empty()) {
    step.missing =
        facts.wanted.empty() ? "nothing is wanted (step 1)" : "nothing is validated (step 4)";
    return step;
  }
  step.figures = figures_of(facts.verified, facts);
  std::erase_if(step.figures, [](const ProcedureFigure& figure) { return !figure.wanted; });
  // A coordinate that is wanted by name and that no point measured is no success.
  std::string unmeasured;
  for (const auto& one : facts.wanted) {
    const bool is_measured = std::ranges::any_of(step.figures, [&](const ProcedureFigure& figure) {
      return one.coordinate.empty() ? figure.unit == one.unit : figure.coordinate == one.coordinate;
    });
    if (is_measured) continue;
    step.figures.push_back({one.coordinate, one.unit, std::nullopt, one.a90});
    unmeasured += (unmeasured.empty() ? "" : ", ") + wanted_text(std::span(&one, 1));
  }
  std::string missed;
  for (const auto& one : step.figures)
    if (is_missed(one))
      missed += fmt::format("{}{} {:.1f} {}, wanted {:.4g}", missed.empty() ? "" : "; ",
                            one.coordinate, *one.a90, one.unit, *one.wanted);
  if (!missed.empty()) {
    step.state = State::not_reached;
    step.found = missed;
    go_back(facts, step);
  } else if (facts.model && !facts.model->doubt.empty()) {
    step.state = State::not_reached;
    step.back_to = 2;
    step.missing = fmt::format("back to step 2: A90 {} was measured before the robot changed",
                               judged_text(facts.verified));
    step.command = "driftwise model check";
  } else if (!unmeasured.empty()) {
    step.missing = fmt::format("run {} measured nothing of: {}",
                               facts.verified_run ? *facts.verified_run : 0, unmeasured);
    step.command = "driftwise run start NEW_POSITIONS.csv --compensate --watch";
  } else {
    step.state = State::done;
    step.found =
        fmt::format("A90 {}, wanted: {}", judged_text(facts.verified), wanted_text(facts.wanted));
  }
  return step;
}

}  // namespace

std::vector<ProcedureStep> procedure_steps(const ProcedureFacts& facts) {
  return {sources_step(facts), wanted_step(facts),     measured_step(facts),
          model_step(facts),   validation_step(facts), reached_step(facts)};
}

}  // namespace driftwise::application
