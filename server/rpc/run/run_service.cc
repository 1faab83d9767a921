#include <algorithm>
#include <cmath>

#include "driftwise/v1/run_service.grpc.pb.h"
#include "server/application/checks/model_checks.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/provenance/provenance.h"
#include "server/application/runs/runs.h"
#include "server/application/status/overview.h"
#include "server/application/trajectories/trajectories.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/rpc/configuration/convert_provenance.h"
#include "server/rpc/run/convert_run.h"
#include "server/rpc/run/convert_verification.h"
#include "server/rpc/run/create_run_request.h"
#include "server/rpc/shared/caller.h"
#include "server/rpc/shared/convert_values.h"
#include "server/rpc/shared/request_checks.h"
#include "server/rpc/shared/services.h"
#include "server/rpc/shared/unary.h"
#include "server/rpc/shared/watch_sources.h"

namespace driftwise::rpc {
namespace {

using Context = grpc::CallbackServerContext;
using Reactor = grpc::ServerUnaryReactor;

// Thousands of rows become messages on the reader's thread: the executor has motion to look after.
Result<v1::ListPointsResponse> listed_points(Store& store, RunId run, std::int64_t after_id,
                                             int limit) {
  DRIFTWISE_TRY(const auto points, store.points().points(run, after_id, limit));
  DRIFTWISE_TRY(const auto repeated, store.closures().repeated_points(run));
  v1::ListPointsResponse out;
  out.mutable_points()->Reserve(static_cast<int>(points.size()));
  for (const auto& point : points) {
    auto& told = *out.add_points();
    told = point_from(point);
    told.set_repeated_line(std::ranges::binary_search(repeated, point.id));
  }
  return out;
}

Result<v1::ListAttemptsResponse> listed_attempts(Store& store, RunId run) {
  DRIFTWISE_TRY(const auto attempts, store.points().attempts(run));
  v1::ListAttemptsResponse out;
  out.mutable_attempts()->Reserve(static_cast<int>(attempts.size()));
  for (const auto& attempt : attempts) *out.add_attempts() = attempt_from(attempt);
  return out;
}

class RunService final : public v1::RunService::CallbackService {
 public:
  explicit RunService(const application::Services& cell)
      : host_(cell.host),
        overview_(cell.overview),
        records_(cell.records),
        runs_(cell.runs),
        trajectories_(cell.trajectories),
        checks_(cell.checks),
        provenance_(cell.provenance) {}

  Reactor* GetRun(Context* context, const v1::GetRunRequest* request,
                  v1::GetRunResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->run_id(), "run_id"); !good) co_return good;
      DRIFTWISE_CO_TRY(const auto run, co_await runs_.get(RunId{request->run_id()}));
      *response->mutable_run() = run_from(run);
      auto looking = provenance_.grounds_of_runs({run.id});
      DRIFTWISE_CO_TRY(const auto grounds, co_await std::move(looking));
      add_ground(grounds.front(), true, *response->mutable_run());
      response->set_trajectory_text(utf8_from(run.trajectory_text));
      response->set_rules_json(run.rules_json);
      co_return Result<void>{};
    });
  }

  Reactor* ListRuns(Context* context, const v1::ListRunsRequest* request,
                    v1::ListRunsResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_cursor(request->before_run_id(), "before_run_id"); !good)
        co_return good;
      DRIFTWISE_CO_TRY(const auto limit, limit_from(request->limit(), 50, 1000));
      DRIFTWISE_CO_TRY(auto wanted, metadata_from(request->metadata()));
      auto finding =
          records_.metadata().find_runs(std::move(wanted), limit, request->before_run_id());
      DRIFTWISE_CO_TRY(const auto runs, co_await std::move(finding));
      std::vector<RunId> ids;
      for (const auto& run : runs) ids.push_back(run.id);
      auto looking = provenance_.grounds_of_runs(std::move(ids));
      DRIFTWISE_CO_TRY(const auto grounds, co_await std::move(looking));
      for (std::size_t i = 0; i < runs.size(); ++i) {
        auto& run = *response->add_runs() = run_from(runs[i]);
        add_ground(grounds[i], false, run);
      }
      co_return Result<void>{};
    });
  }

  Reactor* ListPoints(Context* context, const v1::ListPointsRequest* request,
                      v1::ListPointsResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->run_id(), "run_id"); !good) co_return good;
      if (auto good = check_cursor(request->after_point_id(), "after_point_id"); !good)
        co_return good;
      DRIFTWISE_CO_TRY(const auto limit, limit_from(request->limit(), 1000, 10000));
      DRIFTWISE_CO_TRY(auto listed, co_await records_.call(listed_points, RunId{request->run_id()},
                                                           request->after_point_id(), limit));
      response->Swap(&listed);
      co_return Result<void>{};
    });
  }

  Reactor* ListAttempts(Context* context, const v1::ListAttemptsRequest* request,
                        v1::ListAttemptsResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->run_id(), "run_id"); !good) co_return good;
      DRIFTWISE_CO_TRY(auto listed,
                       co_await records_.call(listed_attempts, RunId{request->run_id()}));
      response->Swap(&listed);
      co_return Result<void>{};
    });
  }

  Reactor* ListDatums(Context* context, const v1::ListDatumsRequest* request,
                      v1::ListDatumsResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->run_id(), "run_id"); !good) co_return good;
      DRIFTWISE_CO_TRY(const auto datums,
                       co_await records_.points().data(RunId{request->run_id()}));
      for (const auto& datum : datums) *response->add_datums() = datum_from(datum);
      co_return Result<void>{};
    });
  }

  Reactor* ListClosures(Context* context, const v1::ListClosuresRequest* request,
                        v1::ListClosuresResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_RETURN_IF_ERROR(check_id(request->run_id(), "run_id"));
      DRIFTWISE_CO_TRY(const auto closures,
                       co_await records_.closures().closures(RunId{request->run_id()}));
      for (const auto& closure : closures) *response->add_closures() = closure_from(closure);
      co_return Result<void>{};
    });
  }

  Reactor* CheckTrajectory(Context* context, const v1::CheckTrajectoryRequest* request,
                           v1::CheckTrajectoryResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      if (auto good =
              check_size(request->trajectory_text(), kMostTrajectoryBytes, "trajectory_text");
          !good)
        co_return good;
      auto checking = trajectories_.check("trajectory", request->trajectory_text());
      DRIFTWISE_CO_TRY(const auto check, co_await std::move(checking));
      *response = check_response_from(check);
      co_return Result<void>{};
    });
  }

  Reactor* CreateRun(Context* context, const v1::CreateRunRequest* request,
                     v1::CreateRunResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      DRIFTWISE_CO_TRY(auto asked, create_run_from(*request, overview_.description().run));
      DRIFTWISE_CO_TRY(const auto run,
                       co_await runs_.create(caller_of(*context), std::move(asked)));
      if (!request->validate_only()) *response->mutable_run() = run_from(run);
      co_return Result<void>{};
    });
  }

  grpc::ServerWriteReactor<v1::WatchRunResponse>* WatchRun(
      Context*, const v1::WatchRunRequest* request) override {
    std::optional<RunId> run;
    if (request->has_run_id()) {
      if (auto good = check_id(request->run_id(), "run_id"); !good)
        return refuse_stream<v1::WatchRunResponse>(good.error());
      run = RunId{request->run_id()};
    }
    return Stream<v1::WatchRunResponse>::open(host_.executor(),
                                              watch_run(host_, overview_, runs_, run));
  }

  Reactor* PauseRun(Context* context, const v1::PauseRunRequest* request,
                    v1::PauseRunResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->run_id(), "run_id"); !good) co_return good;
      DRIFTWISE_CO_TRY(const auto run,
                       co_await runs_.pause(caller_of(*context), RunId{request->run_id()}));
      *response->mutable_run() = run_from(run);
      co_return Result<void>{};
    });
  }

  Reactor* ResumeRun(Context* context, const v1::ResumeRunRequest* request,
                     v1::ResumeRunResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->run_id(), "run_id"); !good) co_return good;
      DRIFTWISE_CO_TRY(auto answered, answer_from(request->answer()));
      auto resuming =
          runs_.resume(caller_of(*context), RunId{request->run_id()}, std::move(answered));
      DRIFTWISE_CO_TRY(const auto run, co_await std::move(resuming));
      *response->mutable_run() = run_from(run);
      co_return Result<void>{};
    });
  }

  Reactor* AbortRun(Context* context, const v1::AbortRunRequest* request,
                    v1::AbortRunResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->run_id(), "run_id"); !good) co_return good;
      DRIFTWISE_CO_TRY(const auto reason, line_from(request->reason(), kMostNameBytes, "reason"));
      auto aborting = runs_.abort(caller_of(*context), RunId{request->run_id()}, reason);
      DRIFTWISE_CO_TRY(const auto run, co_await std::move(aborting));
      *response->mutable_run() = run_from(run);
      co_return Result<void>{};
    });
  }

  Reactor* TagRun(Context* context, const v1::TagRunRequest* request,
                  v1::TagRunResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->run_id(), "run_id"); !good) co_return good;
      DRIFTWISE_CO_TRY(auto set, metadata_from(request->set()));
      std::vector<std::string> removed(request->remove().begin(), request->remove().end());
      for (const auto& key : removed)
        if (auto good = check_size(key, kMostNameBytes, "remove"); !good) co_return good;
      auto tagging = runs_.tag(caller_of(*context), RunId{request->run_id()}, std::move(set),
                               std::move(removed));
      DRIFTWISE_CO_TRY(const auto run, co_await std::move(tagging));
      *response->mutable_run() = run_from(run);
      co_return Result<void>{};
    });
  }

  Reactor* VerifyRuns(Context* context, const v1::VerifyRunsRequest* request,
                      v1::VerifyRunsResponse* response) override {
    return answer(host_, context, [this, request, response]() -> Awaitable<Result<void>> {
      if (request->run_ids_size() < 1 || request->run_ids_size() > 16)
        co_return fail(ErrorCode::invalid_argument, reasons::kBadRunCount,
                       "run_ids: found " + std::to_string(request->run_ids_size()) +
                           " runs, expected 1 to 16");
      DRIFTWISE_CO_TRY(auto ids, run_ids_from(request->run_ids()));
      std::optional<ModelId> range;
      if (request->has_model_id()) {
        if (auto good = check_id(request->model_id(), "model_id"); !good) co_return good;
        range = ModelId{request->model_id()};
      }
      std::vector<RunRecord> records;
      for (const RunId id : ids) {
        DRIFTWISE_CO_TRY(auto record, co_await runs_.get(id));
        records.push_back(std::move(record));
      }
      auto verifying = checks_.verify_runs(std::move(ids), range);
      DRIFTWISE_CO_TRY(const auto verification, co_await std::move(verifying));
      *response = verification_from(verification, records);
      co_return Result<void>{};
    });
  }

  Reactor* ConfirmForce(Context* context, const v1::ConfirmForceRequest* request,
                        v1::ConfirmForceResponse* response) override {
    return answer(host_, context, [this, context, request, response]() -> Awaitable<Result<void>> {
      if (auto good = check_id(request->run_id(), "run_id"); !good) co_return good;
      if (!request->has_force_n() || !std::isfinite(request->force_n()))
        co_return fail(ErrorCode::invalid_argument, reasons::kMissingForce,
                       "force_n: found nothing, expected the force that acts now, N");
      DRIFTWISE_CO_TRY(const auto run,
                       co_await runs_.confirm_force(caller_of(*context), RunId{request->run_id()},
                                                    request->force_n()));
      *response->mutable_run() = run_from(run);
      co_return Result<void>{};
    });
  }

 private:
  application::Host& host_;
  application::Overview& overview_;
  application::StoreReader& records_;
  application::Runs& runs_;
  application::Trajectories& trajectories_;
  application::ModelChecks& checks_;
  application::Provenance& provenance_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_run_service(const application::Services& cell) {
  return std::make_unique<RunService>(cell);
}

}  // namespace driftwise::rpc
