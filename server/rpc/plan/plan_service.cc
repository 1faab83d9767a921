// Joint targets are answered on gRPC's own thread: no hop to the executor, no lock.

#include "driftwise/v1/plan_service.grpc.pb.h"
#include "server/application/plans/joint_targets.h"
#include "server/application/plans/plans.h"
#include "server/core/try.h"
#include "server/formats/plan/plan_file.h"
#include "server/rpc/plan/convert_plan.h"
#include "server/rpc/shared/caller.h"
#include "server/rpc/shared/convert_values.h"
#include "server/rpc/shared/request_checks.h"
#include "server/rpc/shared/services.h"
#include "server/rpc/shared/unary.h"

namespace driftwise::rpc {
namespace {

using Context = grpc::CallbackServerContext;
using Reactor = grpc::ServerUnaryReactor;

class PlanService final : public v1::PlanService::CallbackService {
 public:
  explicit PlanService(const application::Services& cell)
      : host_(cell.host), plans_(cell.plans), targets_(cell.joint_targets) {}

  Reactor* AddPlan(Context* context, const v1::AddPlanRequest* request,
                   v1::AddPlanResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      for (const auto& good :
           {check_size(request->text(), formats::kMostPlanBytes, "text"),
            check_size(request->note(), kMostNoteBytes, "note"),
            check_size(request->request_id(), kMostRequestIdBytes, "request_id")})
        if (!good) co_return good;
      auto adding = plans_.add(caller_of(*context), request->text(), clean_line(request->note()),
                               request->request_id());
      DRIFTWISE_CO_TRY(const auto plan, co_await std::move(adding));
      *response->mutable_plan() = plan_from(plan, false);
      co_return Result<void>{};
    });
  }

  Reactor* ListPlans(Context* context, const v1::ListPlansRequest*,
                     v1::ListPlansResponse* response) override {
    return answer(host_, context, [this, response]() -> Awaitable<Result<void>> {
      auto listing = plans_.list();
      DRIFTWISE_CO_TRY(const auto list, co_await std::move(listing));
      for (const auto& plan : list.plans)
        *response->add_plans() = plan_from(plan, list.serving == plan.id);
      response->set_trouble(utf8_from(list.trouble));
      co_return Result<void>{};
    });
  }

  Reactor* GetPlan(Context* context, const v1::GetPlanRequest* request,
                   v1::GetPlanResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->plan_id(), "plan_id"); !good) co_return good;
      auto getting = plans_.get({request->plan_id()});
      DRIFTWISE_CO_TRY(const auto view, co_await std::move(getting));
      *response->mutable_plan() = plan_from(view.record, view.serves);
      response->set_text(utf8_from(view.record.text));
      for (const auto& step : view.steps) response->add_steps(utf8_from(step));
      for (const auto& one : view.promotions)
        *response->add_promotions() = plan_promotion_from(one);
      co_return Result<void>{};
    });
  }

  Reactor* CheckPlan(Context* context, const v1::CheckPlanRequest* request,
                     v1::CheckPlanResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      std::optional<PlanId> id;
      if (request->plan_id() != 0) {
        if (auto good = check_id(request->plan_id(), "plan_id"); !good) co_return good;
        id = PlanId{request->plan_id()};
      } else if (auto good = check_size(request->text(), formats::kMostPlanBytes, "text"); !good) {
        co_return good;
      }
      auto checking = plans_.check(id, request->text());
      DRIFTWISE_CO_TRY(const auto report, co_await std::move(checking));
      fill_plan_check(report, *response);
      co_return Result<void>{};
    });
  }

  Reactor* PromotePlan(Context* context, const v1::PromotePlanRequest* request,
                       v1::PromotePlanResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->plan_id(), "plan_id"); !good) co_return good;
      std::optional<application::Plans::Seen> seen;
      if (request->has_serving_plan_id()) {
        const std::int64_t serving = request->serving_plan_id();
        if (auto good = check_id(serving, "serving_plan_id"); serving != 0 && !good) co_return good;
        seen.emplace();
        if (serving != 0) seen->serving = PlanId{serving};
      }
      auto promoting =
          plans_.promote(caller_of(*context), {request->plan_id()}, request->confirmed(), seen);
      DRIFTWISE_CO_TRY(const auto plan, co_await std::move(promoting));
      *response->mutable_plan() = plan_from(plan, true);
      co_return Result<void>{};
    });
  }

  Reactor* RollBackPlan(Context* context, const v1::RollBackPlanRequest* request,
                        v1::RollBackPlanResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      std::optional<PlanId> from;
      if (request->has_serving_plan_id()) from = PlanId{request->serving_plan_id()};
      auto rolling = plans_.roll_back(caller_of(*context), from);
      DRIFTWISE_CO_TRY(const auto plan, co_await std::move(rolling));
      if (plan) *response->mutable_plan() = plan_from(*plan, true);
      co_return Result<void>{};
    });
  }

  Reactor* ComputeJointTarget(Context* context, const v1::ComputeJointTargetRequest* request,
                              v1::ComputeJointTargetResponse* response) override {
    return answer_now(context, compute(*request, *response));
  }

 private:
  Result<void> compute(const v1::ComputeJointTargetRequest& request,
                       v1::ComputeJointTargetResponse& response) const {
    static const plans::JointSnapshot nothing;  // its refusal says that no plan serves
    const auto read = targets_.board().read();
    const auto& snapshot = read ? *read : nothing;
    DRIFTWISE_TRY(auto pose, joint_request_from(request.pose(), snapshot, host_.now()));
    pose.show_unreachable = request.show_unreachable();
    return answer_joint_target(snapshot, pose, *response.mutable_target());
  }

  application::Host& host_;
  application::Plans& plans_;
  application::JointTargets& targets_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_plan_service(const application::Services& cell) {
  return std::make_unique<PlanService>(cell);
}

}  // namespace driftwise::rpc
