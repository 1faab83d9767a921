#include "driftwise/v1/trajectory_service.grpc.pb.h"
#include "server/application/plumbing/run_on.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/trajectories/trajectories.h"
#include "server/core/reasons.h"
#include "server/core/trajectory/trajectory_generator.h"
#include "server/core/try.h"
#include "server/formats/csv/trajectory_csv.h"
#include "server/rpc/shared/caller.h"
#include "server/rpc/shared/convert_values.h"
#include "server/rpc/shared/request_checks.h"
#include "server/rpc/shared/services.h"
#include "server/rpc/shared/unary.h"

namespace driftwise::rpc {
namespace {

using Context = grpc::CallbackServerContext;
using Reactor = grpc::ServerUnaryReactor;

v1::Trajectory kept_trajectory_from(const KeptTrajectory& kept) {
  v1::Trajectory out;
  out.set_id(kept.id.value);
  out.set_name(utf8_from(kept.name));
  out.set_text(utf8_from(kept.text));
  out.set_row_count(kept.rows);
  out.set_created_by(utf8_from(kept.created_by));
  *out.mutable_create_time() = timestamp_from(kept.created);
  out.set_hash(kept.hash);
  return out;
}

Result<GeneratorPlan> generator_plan_from(const v1::GenerateTrajectoryRequest& request) {
  GeneratorPlan plan;
  for (const auto& axis : request.axes()) {
    auto coordinate = parse_robot_channel(axis.coordinate());
    if (!coordinate)
      return fail(ErrorCode::invalid_argument, reasons::kBadPlan,
                  "axes: " + coordinate.error().message);
    plan.axes.push_back({std::move(*coordinate), axis.from_mm(), axis.to_mm(), axis.count()});
  }
  plan.line_length = request.line_length();
  plan.with_validation = request.with_validation();
  plan.forces_n.assign(request.forces_n().begin(), request.forces_n().end());
  plan.repeats = request.repeat_count() == 0 ? 1 : request.repeat_count();
  plan.both_directions = request.both_directions();
  if (request.has_shuffle_seed())
    plan.shuffle_seed = static_cast<std::uint64_t>(request.shuffle_seed());
  return plan;
}

Result<std::string> generated_text(const GeneratorPlan& plan) {
  DRIFTWISE_TRY(const auto trajectory, generate_trajectory(plan));
  return formats::write_trajectory_csv(trajectory);
}

class TrajectoryService final : public v1::TrajectoryService::CallbackService {
 public:
  explicit TrajectoryService(const application::Services& cell)
      : host_(cell.host), records_(cell.records), trajectories_(cell.trajectories) {}

  Reactor* CreateTrajectory(Context* context, const v1::CreateTrajectoryRequest* request,
                            v1::CreateTrajectoryResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(const auto name, line_from(request->name(), kMostNameBytes, "name"));
      if (auto good = check_size(request->text(), kMostTrajectoryBytes, "text"); !good)
        co_return good;
      auto keeping = trajectories_.keep(caller_of(*context), name, request->text());
      DRIFTWISE_CO_TRY(const auto kept, co_await std::move(keeping));
      *response->mutable_trajectory() = kept_trajectory_from(kept);
      co_return Result<void>{};
    });
  }

  Reactor* GetTrajectory(Context* context, const v1::GetTrajectoryRequest* request,
                         v1::GetTrajectoryResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->trajectory_id(), "trajectory_id"); !good) co_return good;
      DRIFTWISE_CO_TRY(const auto kept,
                       co_await records_.trajectories().trajectory({request->trajectory_id()}));
      *response->mutable_trajectory() = kept_trajectory_from(kept);
      co_return Result<void>{};
    });
  }

  Reactor* ListTrajectories(Context* context, const v1::ListTrajectoriesRequest*,
                            v1::ListTrajectoriesResponse* response) override {
    return answer(host_, context, [this, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(const auto all, co_await records_.trajectories().trajectories());
      for (const auto& kept : all) *response->add_trajectories() = kept_trajectory_from(kept);
      co_return Result<void>{};
    });
  }

  Reactor* GenerateTrajectory(Context* context, const v1::GenerateTrajectoryRequest* request,
                              v1::GenerateTrajectoryResponse* response) override {
    // Stores nothing and moves nothing, but what it makes must be fit for this cell.
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(const auto plan, generator_plan_from(*request));
      DRIFTWISE_CO_TRY(auto text,
                       co_await application::run_on(host_.background(), generated_text, plan));
      auto checking = trajectories_.check("trajectory", text);
      DRIFTWISE_CO_TRY(const auto checked, co_await std::move(checking));
      response->set_text(std::move(text));
      response->set_row_count(static_cast<std::int64_t>(checked.trajectory.points.size()));
      co_return Result<void>{};
    });
  }

 private:
  application::Host& host_;
  application::StoreReader& records_;
  application::Trajectories& trajectories_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_trajectory_service(const application::Services& cell) {
  return std::make_unique<TrajectoryService>(cell);
}

}  // namespace driftwise::rpc
