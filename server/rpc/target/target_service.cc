// Unary targets are answered on gRPC's own thread: no hop to the executor, no lock. Those of an arm
// whose joints have to be searched for, and its maps, are answered on the background thread, eight
// waiting at most: gRPC's threads are also those that a Stop comes in by.

#include <atomic>
#include <memory>

#include "driftwise/v1/target_service.grpc.pb.h"
#include "server/application/plumbing/run_on.h"
#include "server/application/ports/host.h"
#include "server/application/serving/targets.h"
#include "server/application/status/overview.h"
#include "server/core/reasons.h"
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
    const auto pose = asked_by(*request);
    if (!pose) return answer_now(context, tl::unexpected(pose.error()));
    static const compensation::Snapshot nothing;  // its refusal says that no model serves
    const auto snapshot = targets_.snapshots().read();
    const auto& present = snapshot ? *snapshot : nothing;
    if (!compensation::needs_search(present, *pose))
      return answer_now(context, answer_target(present, *pose, request->with_budget(),
                                               *response->mutable_target()));
    const auto place = searches_->take();
    if (!place) return answer_now(context, too_many_searches());
    return answer(host_, context,
                  [this, place, request, response, pose = *pose,
                   kept = std::make_shared<const compensation::Snapshot>(
                       present)]() -> Awaitable<Result<void>> {
                    co_return co_await application::run_on(host_.background(), &searched, kept,
                                                           pose, request, response);
                  });
  }

  grpc::ServerUnaryReactor* MapTargets(grpc::CallbackServerContext* context,
                                       const v1::MapTargetsRequest* request,
                                       v1::MapTargetsResponse* response) override {
    static const compensation::Snapshot nothing;
    const auto snapshot = targets_.snapshots().read();
    const auto& present = snapshot ? *snapshot : nothing;
    if (!compensation::may_search(present))
      return answer_now(context, map_targets(present, *request, host_.now(), *response));
    const auto place = searches_->take();
    if (!place) return answer_now(context, too_many_searches());
    return answer(host_, context,
                  [this, place, context, request, response, now = host_.now(),
                   kept = std::make_shared<const compensation::Snapshot>(
                       present)]() -> Awaitable<Result<void>> {
                    DRIFTWISE_CO_TRY(const auto map, begin_map(*kept, *request, *response));
                    // One row at a time: work of others comes in between.
                    for (int row = 0; row < map.vertical.count() && !context->IsCancelled(); ++row)
                      DRIFTWISE_CO_RETURN_IF_ERROR(co_await application::run_on(
                          host_.background(), &mapped, kept, map, row, now, response));
                    co_return Result<void>{};
                  });
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
    return Stream<v1::WatchTargetsResponse>::open(
        host_.executor(), watch_targets(host_, targets_, *pose, *interval,
                                        [searches = searches_] { return searches->take(); }));
  }

 private:
  // Places of the searches that wait, or are at work.
  class Searches : public std::enable_shared_from_this<Searches> {
   public:
    // Null: all are taken. It is given back with the last owner.
    std::shared_ptr<void> take() {
      const std::shared_ptr<void> place(this,
                                        [kept = shared_from_this()](void*) { --kept->taken_; });
      return ++taken_ > kMostSearches ? nullptr : place;
    }

   private:
    std::atomic<int> taken_{0};
  };

  static constexpr int kMostSearches = 8;
  static tl::unexpected<Error> too_many_searches() {
    return fail(ErrorCode::resource_exhausted, reasons::kBusy,
                std::to_string(kMostSearches) +
                    " searches of an arm's joints are waiting, which is the most; ask again in a "
                    "moment, or state angles that are near the solution");
  }

  Result<compensation::TargetRequest> asked_by(const v1::ComputeTargetRequest& request) const {
    DRIFTWISE_TRY(auto pose, pose_from(request.pose(), host_.now()));
    pose.show_unreachable = request.show_unreachable();
    DRIFTWISE_RETURN_IF_ERROR(take_near(request.near(), pose));
    return pose;
  }

  static Result<void> searched(const std::shared_ptr<const compensation::Snapshot>& snapshot,
                               const compensation::TargetRequest& pose,
                               const v1::ComputeTargetRequest* request,
                               v1::ComputeTargetResponse* response) {
    return answer_target(*snapshot, pose, request->with_budget(), *response->mutable_target());
  }

  static Result<void> mapped(const std::shared_ptr<const compensation::Snapshot>& snapshot,
                             const TargetMap& map, int row, CellTime now,
                             v1::MapTargetsResponse* response) {
    return add_map_row(*snapshot, map, row, now, *response);
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
  const std::shared_ptr<Searches> searches_ = std::make_shared<Searches>();
};

}  // namespace

std::unique_ptr<grpc::Service> make_target_service(const application::Services& cell) {
  return std::make_unique<TargetService>(cell);
}

}  // namespace driftwise::rpc
