#include "server/application/improvement/improvements_service.h"

#include <fmt/format.h>

#include <cmath>

#include "server/application/datasets/declared_channels.h"
#include "server/application/improvement/plan_rows.h"
#include "server/application/ports/run_plan.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/diagnosis/robot_names.h"

namespace driftwise::application {
namespace {

constexpr int kMostTurns = 50;

Result<void> check_limits(const ImproveRequest& request) {
  if (request.max_turns < 1 || request.max_turns > kMostTurns)
    return fail(
        ErrorCode::invalid_argument, reasons::kBadTurns,
        fmt::format("max_turns: found {}, expected 1 to {}", request.max_turns, kMostTurns));
  if (!std::isfinite(request.budget_s) || request.budget_s < 0)
    return fail(ErrorCode::invalid_argument, reasons::kBadBudget,
                fmt::format("budget: found {:g} s, expected 0 (none) or more", request.budget_s));
  return {};
}

}  // namespace

Awaitable<Result<ImprovementRecord>> ImprovementsService::create(Caller caller,
                                                                 ImproveRequest request) {
  DRIFTWISE_CO_RETURN_IF_ERROR(check_limits(request));
  // What the first run would be refused for is said now.
  DRIFTWISE_CO_RETURN_IF_ERROR(right_.check(request.lease_token));
  auto checking = trajectories_.check("trajectory", request.trajectory_text);
  DRIFTWISE_CO_TRY(const auto check, co_await std::move(checking));
  if (request.budget_s > 0 && check.estimated_s > request.budget_s)
    co_return fail(
        ErrorCode::invalid_argument, reasons::kBadBudget,
        fmt::format("one measurement takes about {:.0f} s, the budget is {:g} s: give it "
                    "more time, or fewer points",
                    check.estimated_s, request.budget_s));
  std::string formula = request.formula;
  if (formula.empty()) {
    DiagnosisRequest baseline;
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await diagnoses_.resolve_baseline(baseline));
    formula = baseline.baseline;
  }
  const auto declared = declared_channels(description_);
  DRIFTWISE_CO_TRY(const auto robot, formats::robot_asked_for(declared, formula, request.robot));
  if (!robot.empty()) {
    if (request.promotes)
      co_return fail(ErrorCode::failed_precondition, reasons::kNotAMotorModel,
                     fmt::format("a model of robot {} serves within a serving plan, it is not "
                                 "promoted by itself: leave --promote out, and name the model "
                                 "that comes of it in the plan (driftwise plan add)",
                                 robot));
    const formats::RobotNames names(declared, robot);
    request.formula = formula = names.with_id(names.bare(formula));
  }
  // Everything that is known to fail before the robot moves.
  DRIFTWISE_CO_RETURN_IF_ERROR(check_setup(description_, request.setup));
  DRIFTWISE_CO_RETURN_IF_ERROR(check_plan_rows(description_, check.trajectory, formula));
  auto beginning = improver_.begin(std::move(caller), std::move(request), std::move(formula));
  co_return co_await std::move(beginning);
}

Awaitable<Result<ImprovementRecord>> ImprovementsService::cancel(Caller caller, ImprovementId id) {
  auto cancelling = improver_.cancel(std::move(caller), id);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(cancelling));
  co_return co_await reader_.call(
      [id](Store& store) { return store.improvements().improvement(id); });
}

std::shared_ptr<void> ImprovementsService::watch(
    std::function<void(const ImprovementProgress&)> on_change) {
  improver_.tell_present(on_change);
  return improver_.watchers().add(std::move(on_change));
}

}  // namespace driftwise::application
