// Unary targets are answered on gRPC's own thread: no hop to the executor, no lock.

#include "driftwise/v1/target_service.grpc.pb.h"
#include "server/application/ports/host.h"
#include "server/application/serving/targets.h"
#include "server/application/status/overview.h"
#include "server/core/try.h"
#include "server/rpc/shared/convert_values.h"
#include "server/rpc/shared/services.h"
#include "server/rpc/shared/unary.h"
#include "server/rpc/shared/watch_sources.h"
#include "server/rpc/target/convert_past_targets.h"
#include "server/rpc/target/convert_target.h"
#include "server/rpc/target/map_targets.h"

namespace driftwise::rpc {
namespace {

class TargetService final : public v1::TargetService::CallbackService {
 public:
  explicit TargetService(const application::Services& cell)
      : host_(cell.host), overview_(cell.overview), targets_(cell.targets) {}

  grpc::ServerUnaryReactor* ComputeTarget(grpc::CallbackServerContext* context,
                                          const v1::ComputeTargetRequest* request,
                                          v1::ComputeTargetResponse* response) override {
    return answer_now(context, compute(*request, *response));
  }

  grpc::ServerUnaryReactor* MapTargets(grpc::CallbackServerContext* context,
                                       const v1::MapTargetsRequest* request,
                                       v1::MapTargetsResponse* response) override {
    static const compensation::Snapshot nothing;
    const auto snapshot = targets_.snapshots().read();
    return answer_now(
        context, map_targets(snapshot ? *snapshot : nothing, *request, host_.now(), *response));
  }

  grpc::ServerUnaryReactor* ListPastTargets(grpc::CallbackServerContext* context,
                                            const v1::ListPastTargetsRequest* request,
                                            v1::ListPastTargetsResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(auto query, past_targets_query_from(*request));
      auto asking = targets_.past(std::move(query));
      DRIFTWISE_CO_TRY(const auto past, co_await std::move(asking));
      fill_past_targets(past, *response);
      co_return Result<void>{};
    });
  }

  grpc::ServerUnaryReactor* EstimatePose(grpc::CallbackServerContext* context,
                                         const v1::EstimatePoseRequest* request,
                                         v1::EstimatePoseResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      co_return estimate(*request, *response);
    });
  }

  grpc::ServerWriteReactor<v1::WatchTargetsResponse>* WatchTargets(
      grpc::CallbackServerContext*, const v1::WatchTargetsRequest* request) override {
    auto pose = pose_from(request->pose(), CellTime{});
    if (!pose) return refuse_stream<v1::WatchTargetsResponse>(pose.error());
    pose->show_unreachable = request->show_unreachable();
    if (const auto near = take_near(request->near(), *pose); !near)
      return refuse_stream<v1::WatchTargetsResponse>(near.error());
    const auto interval =
        nanoseconds_from(request->min_interval_duration(), "min_interval_duration");
    if (!interval) return refuse_stream<v1::WatchTargetsResponse>(interval.error());
    return Stream<v1::WatchTargetsResponse>::open(host_.executor(),
                                                  watch_targets(host_, targets_, *pose, *interval));
  }

 private:
  Result<void> compute(const v1::ComputeTargetRequest& request,
                       v1::ComputeTargetResponse& response) const {
    DRIFTWISE_TRY(auto pose, pose_from(request.pose(), host_.now()));
    pose.show_unreachable = request.show_unreachable();
    DRIFTWISE_RETURN_IF_ERROR(take_near(request.near(), pose));
    static const compensation::Snapshot nothing;  // its refusal says that no model serves
    const auto snapshot = targets_.snapshots().read();
    return answer_target(snapshot ? *snapshot : nothing, pose, request.with_budget(),
                         *response.mutable_target());
  }

  Result<void> estimate(const v1::EstimatePoseRequest& request,
                        v1::EstimatePoseResponse& response) const {
    Present present;
    for (const auto& latest : overview_.status().values)
      if (!latest.stale && !is_missing(latest.value)) present[latest.channel.name()] = latest.value;
    static const compensation::Snapshot nothing;
    const auto snapshot = targets_.snapshots().read();
    return answer_pose(snapshot ? *snapshot : nothing, request, present, host_.now(), response);
  }

  application::Host& host_;
  application::Overview& overview_;
  application::Targets& targets_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_target_service(const application::Services& cell) {
  return std::make_unique<TargetService>(cell);
}

}  // namespace driftwise::rpc
