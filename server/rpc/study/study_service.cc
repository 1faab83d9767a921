#include "driftwise/v1/study_service.grpc.pb.h"
#include "server/application/models/model_integrity.h"
#include "server/application/models/models.h"
#include "server/application/plumbing/run_on.h"
#include "server/application/procedure/procedures.h"
#include "server/application/provenance/provenance.h"
#include "server/application/status/overview.h"
#include "server/compensation/design_study.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/rpc/shared/request_checks.h"
#include "server/rpc/shared/services.h"
#include "server/rpc/shared/unary.h"
#include "server/rpc/study/convert_procedure.h"

namespace driftwise::rpc {
namespace {

constexpr int kMostChanges = 64;

class StudyService final : public v1::StudyService::CallbackService {
 public:
  explicit StudyService(const application::Services& cell) : cell_(cell), procedures_(cell) {}

  grpc::ServerUnaryReactor* GetProcedure(grpc::CallbackServerContext* context,
                                         const v1::GetProcedureRequest*,
                                         v1::GetProcedureResponse* response) override {
    return answer(cell_.host, context, [this, response]() -> Awaitable<Result<void>> {
      auto looking = procedures_.steps();
      DRIFTWISE_CO_TRY(const auto steps, co_await std::move(looking));
      for (const auto& step : steps) *response->add_steps() = step_from(step);
      co_return Result<void>{};
    });
  }

  grpc::ServerUnaryReactor* StudyDesign(grpc::CallbackServerContext* context,
                                        const v1::StudyDesignRequest* request,
                                        v1::StudyDesignResponse* response) override {
    return answer(cell_.host, context, [this, request, response]() -> Awaitable<Result<void>> {
      if (request->changes_size() > kMostChanges)
        co_return fail(ErrorCode::invalid_argument, reasons::kWrongCount,
                       "changes: found " + std::to_string(request->changes_size()) +
                           ", expected at most " + std::to_string(kMostChanges));
      auto id = cell_.overview.status().serving;
      if (request->has_model_id()) {
        DRIFTWISE_CO_RETURN_IF_ERROR(check_id(request->model_id(), "model_id"));
        id = ModelId{request->model_id()};
      }
      if (!id)
        co_return fail(ErrorCode::failed_precondition, reasons::kNoModel,
                       "no model serves: name one (driftwise design --model N)");
      DRIFTWISE_CO_TRY(const auto record, co_await cell_.models.get(*id));
      auto looking = cell_.provenance.ground_of_model(*id);
      DRIFTWISE_CO_TRY(const auto ground, co_await std::move(looking));
      DRIFTWISE_CO_TRY(const auto model,
                       application::read_formula_model(record, "designs are studied"));
      // Of a file nobody kept the rows; a run's can be gone.
      auto reading = cell_.models.residuals(*id, {}, "");
      const auto rows = co_await std::move(reading);
      const auto& cell =
          ground.measured_under ? *ground.measured_under : cell_.overview.description();
      const std::vector<std::string> changes(request->changes().begin(), request->changes().end());
      const Dataset* data = rows ? &rows->data : nullptr;
      DRIFTWISE_CO_TRY(const auto study,
                       co_await application::run_on(
                           cell_.host.background(),
                           [](const calibration::Model& of, const CellDescription& measured_under,
                              const std::vector<std::string>& changed, const Dataset* known) {
                             return compensation::study_design(of, measured_under, changed, known);
                           },
                           model, cell, changes, data));
      response->set_model_id(id->value);
      put(study, *response);
      co_return Result<void>{};
    });
  }

 private:
  application::Services cell_;
  application::Procedures procedures_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_study_service(const application::Services& cell) {
  return std::make_unique<StudyService>(cell);
}

}  // namespace driftwise::rpc
