#include "server/application/plans/plans_service.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "server/application/plumbing/run_on.h"
#include "server/application/provenance/promotion_questions.h"
#include "server/application/provenance/stored_description.h"
#include "server/core/reasons.h"
#include "server/core/records/served_in_order.h"
#include "server/core/try.h"
#include "server/formats/model/model_json.h"
#include "server/formats/plan/plan_file.h"
#include "server/plans/robot_parts.h"

namespace driftwise::application {
namespace {

// The tool that a run was measured with: what people said of the run, else the cell file in force.
// Empty: neither says.
std::string tool_of(Store& store, RunId run, const std::string& robot,
                    const CellDescription& present) {
  const auto record = store.runs().run(run);
  if (!record) return "";
  const auto said = [&](const std::string& key) -> std::string {
    for (const auto& item : record->metadata)
      if (item.key == key) return item.value;
    return "";
  };
  if (const auto own = said(robot + ".tool"); !robot.empty() && !own.empty()) return own;
  if (const auto any = said("tool"); !any.empty()) return any;
  const auto cell = stored_description(store, record->config_hash, present);
  if (!cell) return "";
  for (const auto& one : cell->robots)
    if (one.id == robot || (robot.empty() && cell->robots.size() == 1)) return one.tool;
  return "";
}

std::vector<std::string> tools_of(Store& store, const std::vector<RunId>& runs,
                                  const std::string& robot, const CellDescription* present) {
  std::vector<std::string> tools;
  for (const RunId run : runs)
    if (auto tool = tool_of(store, run, robot, *present);
        !tool.empty() && std::ranges::find(tools, tool) == tools.end())
      tools.push_back(std::move(tool));
  return tools;
}

ServedInOrder<PlanId> plans_served(const std::vector<PlanPromotionRecord>& history) {
  ServedInOrder<PlanId> served;
  for (const auto& step : history) {
    if (step.action == "rollback")
      served.rolled_back(step.plan);
    else if (step.plan)
      served.promoted(*step.plan);
  }
  return served;
}

std::string plan_name(const std::optional<PlanId>& plan) {
  return plan ? fmt::format("plan {}", plan->value) : std::string();
}

}  // namespace

Awaitable<Result<PlanRecord>> PlansService::add(Caller caller, std::string text, std::string note,
                                                std::string request_id) {
  DRIFTWISE_CO_TRY(const auto plan, formats::read_plan_file(text, "plan"));
  PlanRecord record;
  record.name = plan.name;
  record.hash = formats::plan_hash(text);
  record.text = std::move(text);
  record.created = clock_.now().utc;
  record.created_by = caller.name;
  record.created_from = caller.peer;
  record.note = std::move(note);
  record.request_id = std::move(request_id);
  for (const ModelId model : plan.models()) {
    auto getting = models_.get(model);
    DRIFTWISE_CO_TRY(const auto found, co_await std::move(getting));
    record.models.emplace_back(model, found.hash);
  }
  DRIFTWISE_CO_TRY(auto stored, co_await writer_.plans().add_plan(record));
  if (stored.created == record.created)
    events_.record(caller, "plan.added",
                   fmt::format("{} added plan {} '{}', version {}", caller.name, stored.id.value,
                               stored.name, stored.version),
                   {}, {plan_name(stored.id), "", stored.hash});
  co_return stored;
}

Awaitable<Result<PlanList>> PlansService::list() {
  PlanList out;
  DRIFTWISE_CO_TRY(out.plans, co_await reader_.plans().plans());
  out.serving = serving_.plan();
  out.trouble = serving_.trouble();
  co_return out;
}

Awaitable<Result<plans::ServingPlan>> PlansService::whole_plan(const PlanRecord& record) const {
  if (formats::plan_hash(record.text) != record.hash)
    co_return fail(ErrorCode::data_loss, reasons::kPlanDamaged,
                   fmt::format("plan {} is not what was stored: its text has another hash; add it "
                               "again from its file",
                               record.id.value));
  co_return formats::read_plan_file(record.text, fmt::format("plan {}", record.id.value));
}

Awaitable<Result<PlanView>> PlansService::get(PlanId id) {
  PlanView view;
  DRIFTWISE_CO_TRY(view.record, co_await reader_.plans().plan(id));
  DRIFTWISE_CO_TRY(view.promotions, co_await reader_.plans().plan_promotions());
  auto reading = whole_plan(view.record);
  DRIFTWISE_CO_TRY(const auto plan, co_await std::move(reading));
  view.steps = plans::steps_of(plan);
  view.serves = serving_.plan() == id;
  co_return view;
}

Awaitable<Result<PlansService::Loaded>> PlansService::load(plans::ServingPlan plan,
                                                           bool missing_is_empty) {
  Loaded loaded;
  for (const ModelId id : plan.models()) {
    auto getting = models_.get(id);
    auto found = co_await std::move(getting);
    if (!found && missing_is_empty && found.error().code == ErrorCode::not_found) continue;
    DRIFTWISE_CO_TRY(const auto record, std::move(found));
    DRIFTWISE_CO_TRY(auto model, formats::read_model_json(record.json));
    const auto robots = plans::robots_of(model);
    std::string robot;
    if (!robots.empty()) robot = *robots.begin();
    loaded.tools[id] =
        co_await reader_.call(tools_of, model.lineage.runs, std::move(robot), &description_);
    loaded.models.emplace(id, std::move(model));
  }
  loaded.plan = std::move(plan);
  co_return loaded;
}

Awaitable<Result<std::vector<plans::PlanFinding>>> PlansService::questions_of_models(
    const Loaded& loaded) const {
  std::vector<plans::PlanFinding> found;
  for (const auto& [id, model] : loaded.models) {
    auto asking = provenance_.ground_of_model(id);
    DRIFTWISE_CO_TRY(const auto ground, co_await std::move(asking));
    for (const auto& question : ground.promotion_questions)
      found.push_back(
          {false, reasons::kNeedsConfirmation, fmt::format("(model {}) {}", id.value, question)});
  }
  co_return found;
}

Awaitable<Result<PlanReport>> PlansService::check(std::optional<PlanId> id, std::string text) {
  plans::ServingPlan plan;
  if (id) {
    DRIFTWISE_CO_TRY(const auto record, co_await reader_.plans().plan(*id));
    auto reading = whole_plan(record);
    DRIFTWISE_CO_TRY(plan, co_await std::move(reading));
  } else {
    DRIFTWISE_CO_TRY(plan, formats::read_plan_file(text, "plan"));
  }
  PlanReport report;
  report.steps = plans::steps_of(plan);
  auto loading = load(std::move(plan), true);
  DRIFTWISE_CO_TRY(auto loaded, co_await std::move(loading));
  auto asking = questions_of_models(loaded);
  DRIFTWISE_CO_TRY(auto of_models, co_await std::move(asking));
  report.check = co_await run_on(
      worker_,
      [cell = &description_](const Loaded& all) {
        return plans::check_plan(all.plan, all.models, all.tools, *cell);
      },
      std::move(loaded));
  std::ranges::move(of_models, std::back_inserter(report.check.findings));
  co_return report;
}

Awaitable<Result<void>> PlansService::put_in_service(Caller caller, std::optional<PlanRecord> next,
                                                     std::string action) {
  const auto before = serving_.plan();
  // First see that it can serve, then write it down: what stands in the record is what serves.
  const auto serve = [this](std::optional<PlanRecord> record) -> Awaitable<Result<void>> {
    if (!record) {
      serving_.serve_none();
      co_return Result<void>{};
    }
    auto reading = whole_plan(*record);
    DRIFTWISE_CO_TRY(auto plan, co_await std::move(reading));
    auto loading = load(std::move(plan), false);
    DRIFTWISE_CO_TRY(auto loaded, co_await std::move(loading));
    co_return co_await serving_.serve(record->id, std::move(loaded.plan), std::move(loaded.models));
  };
  auto serving = serve(next);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(serving));
  const std::optional<PlanId> now = next ? std::optional(next->id) : std::nullopt;
  PlanPromotionRecord promotion{now, clock_.now().utc, caller.name, caller.peer, action};
  if (auto stored = co_await writer_.plans().add_plan_promotion(promotion); !stored) {
    std::optional<PlanRecord> previous;
    if (before)
      if (auto record = co_await reader_.plans().plan(*before)) previous = std::move(*record);
    auto back = serve(std::move(previous));
    static_cast<void>(co_await std::move(back));
    co_return stored;
  }
  events_.record(caller, "plan." + action,
                 next ? fmt::format("plan {} '{}', version {}, serves, by {}", next->id.value,
                                    next->name, next->version, caller.name)
                      : fmt::format("no plan serves, by {}", caller.name),
                 {}, {"serving plan", plan_name(before), plan_name(now)});
  co_return Result<void>{};
}

Awaitable<Result<PlanRecord>> PlansService::promote(Caller caller, PlanId id, bool confirmed,
                                                    std::optional<Seen> seen) {
  DRIFTWISE_CO_TRY(auto record, co_await reader_.plans().plan(id));
  if (serving_.plan() == id) co_return record;  // it serves already
  auto checking = check(id, {});
  DRIFTWISE_CO_TRY(const auto report, co_await std::move(checking));
  if (const auto refusal = report.check.refusal(); !refusal) {
    events_.record(caller, "plan.promote", fmt::format("plan {} was not promoted", id.value), {},
                   {"serving plan", plan_name(serving_.plan()), plan_name(id),
                    refusal.error().reason + ": " + refusal.error().message});
    co_return tl::unexpected(refusal.error());
  }
  const auto questions = report.check.questions();
  if (!confirmed) DRIFTWISE_CO_RETURN_IF_ERROR(confirmation_of(questions));
  const auto held = co_await changing_.lock();
  if (seen && serving_.plan() != seen->serving)
    co_return fail(
        ErrorCode::failed_precondition, reasons::kStale,
        fmt::format("{} serves by now, where {} was seen to serve: plan {} was not promoted; look "
                    "at what serves, then promote it again",
                    serving_.plan() ? plan_name(serving_.plan()) : "no plan",
                    seen->serving ? plan_name(seen->serving) : "no plan", id.value));
  for (const auto& question : questions)
    events_.record(caller, "plan.confirmed",
                   fmt::format("{} promotes plan {} although {}", caller.name, id.value, question));
  auto putting = put_in_service(std::move(caller), record, "promote");
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(putting));
  co_return record;
}

Awaitable<Result<std::optional<PlanRecord>>> PlansService::roll_back(Caller caller,
                                                                     std::optional<PlanId> from) {
  const auto held = co_await changing_.lock();
  if (from && serving_.plan() != from)
    co_return fail(
        ErrorCode::failed_precondition, reasons::kStale,
        fmt::format("{} serves by now, where plan {} was to be taken back: nothing was rolled "
                    "back; look at the list of promotions, then try again",
                    serving_.plan() ? plan_name(serving_.plan()) : "no plan", from->value));
  DRIFTWISE_CO_TRY(const auto history, co_await reader_.plans().plan_promotions());
  const auto served = plans_served(history);
  if (served.ids().empty())
    co_return fail(ErrorCode::failed_precondition, reasons::kNothingToRollBack,
                   "no plan serves: there is none to take back");
  std::optional<PlanRecord> previous;
  if (const auto before = served.before()) {
    DRIFTWISE_CO_TRY(auto record, co_await reader_.plans().plan(*before));
    previous = std::move(record);
  }
  auto putting = put_in_service(std::move(caller), previous, "rollback");
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(putting));
  co_return previous;
}

Awaitable<Result<void>> PlansService::restore() {
  DRIFTWISE_CO_TRY(const auto history, co_await reader_.plans().plan_promotions());
  if (history.empty() || !history.back().plan) co_return Result<void>{};
  const PlanId id = *history.back().plan;
  const auto refused = [&](const Error& error) {
    serving_.refuse(id, error);
    return Result<void>(tl::unexpected(error));
  };
  auto record = co_await reader_.plans().plan(id);
  if (!record) co_return refused(record.error());
  auto reading = whole_plan(*record);
  auto plan = co_await std::move(reading);
  if (!plan) co_return refused(plan.error());
  auto loading = load(std::move(*plan), false);
  auto loaded = co_await std::move(loading);
  if (!loaded) co_return refused(loaded.error());
  auto serving = serving_.serve(id, std::move(loaded->plan), std::move(loaded->models));
  if (auto ok = co_await std::move(serving); !ok) co_return refused(ok.error());
  co_return Result<void>{};
}

}  // namespace driftwise::application
